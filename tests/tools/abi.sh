#!/bin/sh
# The symbols of the library.
#
#   abi.sh check|update SHARED STATIC LIST
#
# The exported symbols of SHARED are those of LIST, all begin with sph_; external names inside STATIC
# begin with sph_ or sphi_; and no object has writable data.
set -eu
LC_ALL=C
export LC_ALL
action=$1 shared=$2 static=$3 list=$4
nm=${NM:-nm}
now=$(dirname "$shared")/libsph.sym
$nm -D --defined-only "$shared" | awk '{print $3}' | sed 's/@.*//' | sort >"$now"

status=0
if grep -v '^sph_' "$now"; then
  echo "the names above are exported but do not begin with sph_" >&2
  status=1
fi
if $nm -g --defined-only "$static" | awk 'NF == 3 && $3 !~ /^sphi?_/ {print $3}' | grep .; then
  echo "the external names above do not begin with sph_ or sphi_" >&2
  status=1
fi
# Tables of pointers live in .data.rel.ro and are constant; .data and .bss are not.
if size -A "$static" | awk '/ex / || /:$/ {object = $1} $1 ~ /^\.(t?data|t?bss)(\.|$)/ && $1 !~ /^\.data\.rel\.ro/ && $2 > 0 \
    {print object ": " $2 " bytes in " $1; found = 1} END {exit !found}'; then
  echo "the objects above have writable globals" >&2
  status=1
fi
case $action in
  update)
    mkdir -p "$(dirname "$list")"
    cp "$now" "$list"
    echo "wrote $list: $(wc -l <"$list") symbols"
    ;;
  *)
    if ! diff -u "$list" "$now"; then
      echo "the exported symbols changed; if that is meant, run 'make abi-update' and tell CHANGELOG.md" >&2
      status=1
    else
      echo "$(wc -l <"$list") exported symbols are as listed in $list"
    fi
    ;;
esac
exit $status
