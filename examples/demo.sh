#!/bin/sh
# The dam break at full resolution, compared with measurements: plots, pictures, tables, files for
# ParaView and a page that shows them.
#
#   demo.sh FOLDER [OPTION OF dam_break ...]
#
# For example `demo.sh out --dx 0.01` is done in seconds. BUILD in the environment is where the examples
# were built; they are built if they are not there.
set -eu
export GOMP_SPINCOUNT=${GOMP_SPINCOUNT:-10000} # longer waits of threads slow a shared machine down
root=$(cd "$(dirname "$0")/.." && pwd)
examples=$root/examples
measured=$root/tests/data
[ $# -ge 1 ] || { echo "usage: demo.sh FOLDER [OPTION OF dam_break ...]" >&2; exit 2; }
mkdir -p "$1"
out=$(cd "$1" && pwd)
shift
build=${BUILD:-$root/build}
case $build in /*) ;; *) [ -d "$build" ] && build=$(cd "$build" && pwd) || build=$root/$build ;; esac
[ -x "$build/examples/dam_break" ] || make -C "$root" --no-print-directory BUILD="$build" examples
command -v gnuplot >/dev/null || { echo "demo.sh wants gnuplot (Debian: gnuplot-nox)" >&2; exit 1; }
# shellcheck source=examples/report.sh
. "$examples/report.sh"
rows=$out/rows.txt

# Only what an earlier run left.
rm -rf "$out/dam_break" "$out/front" "$out/hydrostatic" "$out/images" "$rows"
mkdir "$out/images"
start=$(date +%s)
failed=0

# The two small runs share the processors, one thread each.
echo "water at rest, two seconds, dx = 0.01 m"
echo "dam break of Koshizuka and Oka: column of 0.146 x 0.292 m, dx = 2.92 mm"
"$build/examples/hydrostatic" --end 2 --threads 1 --out "$out/hydrostatic" --summary "$out/hydrostatic.json" \
  >"$out/hydrostatic.txt" 2>&1 &
hydrostatic=$!
"$build/examples/dam_break" --height 0.292 --length 0.146 --tank 0.73 --dx 0.00292 --end-t-star 1.8 --threads 1 \
  --out "$out/front" --summary "$out/front.json" >"$out/front.txt" 2>&1 || failed=1
wait "$hydrostatic" || failed=1
tail -q -n 1 "$out/hydrostatic.txt" "$out/front.txt"

echo "dam break of Buchner: column of 1.2 x 0.6 m${*:+, options $*}"
"$build/examples/dam_break" --out "$out/dam_break" --summary "$out/dam_break.json" --vtk 20 --pictures 11 \
  --end-t-star 6.6 "$@" \
  >"$out/dam_break.txt" || failed=1
tail -n 1 "$out/dam_break.txt"
solved=$(($(date +%s) - start))

frames=$(find "$out/dam_break" -name 'picture_*.txt' | wc -l | tr -d ' ')
gnuplot -e "run='$out/dam_break'; images='$out/images'; frames=$frames; tank=5.366; top=2" "$examples/dam_break_pictures.gp" &
pictures=$!
gnuplot -e "run='$out/dam_break'; small='$out/front'; measured='$measured'; images='$out/images'" "$examples/dam_break_plots.gp"
gnuplot -e "run='$out/hydrostatic'; images='$out/images'; name='box'" "$examples/hydrostatic_plots.gp"
wait "$pictures"
dam_break_rows "$out/dam_break.json" "$out/dam_break" "$out/front"

value() { figure "$out/dam_break.json" "$1"; }
{
  cat <<HEAD
<!doctype html>
<html lang="en"><meta charset="utf-8"><title>libsph: dam break</title>
<style>
body { font: 16px/1.5 sans-serif; max-width: 1260px; margin: 2em auto; padding: 0 1em; color: #222 }
img { max-width: 100% } table { border-collapse: collapse; margin: 1em 0 }
td, th { border: 1px solid #ccc; padding: .25em .7em; text-align: left }
tr.yes td:last-child { background: #d7f0d9 } tr.no td:last-child { background: #f7d4d0 }
figure { margin: 0; display: inline-block; width: 49% } nav a { margin-right: 1.2em }
</style>
<h1>Dam break</h1>
<p>A column of water, 1.2 m long and 0.6 m high, collapses in a tank of 3.22 m: δ-SPH with fixed ghost
particles, spacing $(value dx_m) m, $(value particles) particles, $(value steps) steps in
$(value wall_seconds) s on $(value threads) threads ($(value isa), $(value ns_per_particle_step) ns a
particle and step).</p>
<p><img src="images/flow.png" alt="the flow coloured by pressure"></p>
<h2>Against experiment</h2>
HEAD
  rows_as_html
  cat <<'MIDDLE'
<p>The gate of an experiment takes time to open, that of the computation none: the computed front leads by
a nearly constant time. The second peak is that of the mean over 0.1 sqrt(H/g). The bed is smooth.</p>
<figure><img src="images/p1_pressure.png" alt="wall pressure"></figure>
<figure><img src="images/front.png" alt="front"></figure>
<figure><img src="images/energy.png" alt="energy"></figure>
<figure><img src="images/column.png" alt="height at the left wall"></figure>
<h2>Water at rest</h2>
<figure><img src="images/hydrostatic_box_pressure.png" alt="pressure at rest"></figure>
<figure><img src="images/hydrostatic_box_kinetic.png" alt="kinetic energy at rest"></figure>
<h2>Files</h2>
MIDDLE
  echo '<p><nav>'
  for file in dam_break/vtk/water.pvd dam_break.json front.json hydrostatic.json dam_break/*.csv front/front.csv hydrostatic/*.csv; do
    # Unquoted on purpose: patterns stand for files below the folder.
    (cd "$out" && for found in $file; do [ ! -f "$found" ] || echo "<a href=\"$found\">$found</a>"; done)
  done
  echo '</nav></p><h2>Frames</h2><p>'
  (cd "$out" && for file in images/flow_*.png; do echo "<a href=\"$file\"><img width=\"300\" src=\"$file\" alt=\"$file\"></a>"; done)
  echo '</p></html>'
} >"$out/index.html"

echo
rows_as_text
echo
echo "computed in $solved s, all in $(($(date +%s) - start)) s"
echo "page      $out/index.html"
echo "pictures  $out/images/"
echo "series    $out/dam_break/*.csv"
echo "ParaView  $out/dam_break/vtk/water.pvd"
[ "$failed" -eq 0 ] || echo "a run failed or lost particles, see the messages above" >&2
exit "$failed"
