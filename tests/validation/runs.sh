# What run.sh, waves.sh and wave_loss.sh share: options, runs of examples, tables, the end. Sourced with the arguments,
# after `page` and `wants` name the page and an example that must be there. Afterwards `out` is the
# folder, `quick` and `report` are 0 or 1, `rows` is where row() of report.sh collects.
# shellcheck shell=sh disable=SC2034,SC2154
export GOMP_SPINCOUNT=${GOMP_SPINCOUNT:-10000} # longer waits of threads slow a shared machine down
script=$(basename "$0")
root=$(cd "$(dirname "$0")/../.." && pwd)
examples=$root/examples
measured=$root/tests/data
usage() { echo "usage: $script FOLDER [--quick] [--report] [--update]" >&2; exit 2; }
[ $# -ge 1 ] || usage
mkdir -p "$1"
out=$(cd "$1" && pwd)
shift
quick=0 report=0 update=0
for option in "$@"; do
  case $option in
    --quick) quick=1 ;;
    --report) report=1 ;;
    --update) update=1 ;;
    *) usage ;;
  esac
done
build=${BUILD:-$root/build}
case $build in /*) ;; *) [ -d "$build" ] && build=$(cd "$build" && pwd) || build=$root/$build ;; esac
[ -x "$build/examples/$wants" ] || make -C "$root" --no-print-directory BUILD="$build" examples
command -v gnuplot >/dev/null || { echo "$script wants gnuplot (Debian: gnuplot-nox)" >&2; exit 1; }
# shellcheck source=examples/report.sh
. "$examples/report.sh"
rows=$out/rows.txt
: >"$rows"

# run NAME EXAMPLE OPTION ...: one run into $out/NAME; its words are in $out/NAME.txt. A run that fails
# leaves what it has and shows up in the table.
run() {
  name=$1 example=$2
  shift 2
  [ "$report" = 1 ] && return 0
  rm -rf "${out:?}/$name" "$out/$name.json"
  printf '%s: %s %s\n' "$name" "$example" "$*"
  "$build/examples/$example" "$@" --out "$out/$name" --summary "$out/$name.json" >"$out/$name.txt" 2>&1 || true
  tail -n 1 "$out/$name.txt"
}

plot() { gnuplot "$@" || echo "$script: gnuplot failed: $*" >&2; }

# The rows so far as a table of the page.
missed=0
table() {
  rows_as_markdown
  echo
  missed=$((missed + $(rows_failed)))
  : >"$rows"
}

# After the page is written.
finish() {
  rm "$rows"
  for image in "$out"/images/*.png; do
    [ -e "$image" ] || continue # a page without plots
    size=$(wc -c <"$image")
    [ "$size" -le 150000 ] || echo "$script: $image has $size bytes: more than 150000 is too large for docs/images" >&2
  done
  if [ "$update" = 1 ]; then
    mkdir -p "$root/docs/images"
    [ ! -d "$out/images" ] || cp "$out"/images/*.png "$root/docs/images/"
    cp "$out/$page" "$root/docs/$page"
  fi
  echo "$out/$page: $missed figures outside their bars"
}
