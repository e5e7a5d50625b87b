#!/bin/sh
# Runs test programs one after another and adds up their CUnit results.
#
#   run-tests.sh PROGRAM...
#
# Each program ends with a line "tests <suite>: N run, M failed". One that crashes, says nothing of
# the kind, exits with an error without a failed test, or takes longer than TEST_TIMEOUT seconds
# (300) counts as one more failed test. The last line is "N passed, N failed"; the exit status is
# zero when something ran and nothing failed. Each program's output stays beside it in *.log.
set -u
export OMP_WAIT_POLICY=passive # threads that spin while they wait slow a shared machine down
limit=${TEST_TIMEOUT:-300}
passed=0
failed=0
bad=""
for program in "$@"; do
  echo "== $program"
  timeout -k 10 "$limit" "$program" >"$program.log" 2>&1 </dev/null
  status=$?
  cat "$program.log"
  line=$(sed -n 's/^tests .*: \([0-9][0-9]*\) run, \([0-9][0-9]*\) failed$/\1 \2/p' "$program.log" | tail -n 1)
  if [ -n "$line" ]; then
    ran=${line% *}
    lost=${line#* }
    [ "$lost" -gt "$ran" ] && ran=$lost
  else
    ran=0
    lost=0
  fi
  if [ "$lost" -eq 0 ] && { [ -z "$line" ] || [ "$status" -ne 0 ]; }; then
    echo
    case $status in
      124 | 137) echo "$program: took longer than $limit s" ;;
      *) echo "$program: ended with status $status${line:+ after its tests}" ;;
    esac
    ran=$((ran + 1))
    lost=1
  fi
  passed=$((passed + ran - lost))
  failed=$((failed + lost))
  [ "$lost" -gt 0 ] && bad="$bad $program"
done
echo
[ -n "$bad" ] && echo "failed:$bad"
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
