#!/bin/sh
# Every number of Liang et al. (2017) beside ours and beside the exact potential flow of their tank. Writes
# FOLDER/validation_liang.md with tables and plots.
#
#   liang.sh FOLDER [--quick] [--report] [--update] [--study] [--method isph|wcsph]
#
# --quick    coarse, to try the script itself; the figures mean nothing
# --report   write the page from the runs that are in FOLDER already
# --update   copy the page to docs/ and its plots to docs/images/
# --study    run the parameter study too, 300 runs: hours. It goes on where it was; its rows are in FOLDER/study_METHOD.csv
# --method   isph unless told otherwise
# BUILD in the environment is where the examples were built.
set -eu
page=validation_liang.md wants=seawall_study
method=isph study=0
here=$(cd "$(dirname "$0")" && pwd)
for argument in "$@"; do
  shift
  case $argument in
    --study) study=1 ;;
    --method) method= ;;
    *) if [ -n "$method" ]; then set -- "$@" "$argument"; else method=$argument; fi ;;
  esac
done
case $method in isph | wcsph) ;; *) echo "liang.sh: --method is isph or wcsph, got \"$method\"" >&2; exit 2 ;; esac
# shellcheck source=tests/validation/runs.sh
. "$here/runs.sh"

paper=$measured/liang2017_movable_seawall_text_values.csv
heights='0.1 0.2 0.3 0.4 0.5 0.6'
stiffnesses='10 100 1000 10000' masses='50 100 175 250 375 500'
coarse=0.008 study_options= study_csv=$out/study_$method.csv
[ "$quick" = 1 ] && coarse=0.025 study_options='--dx 0.04' study_csv=$out/study_quick_$method.csv

# The piston of the exact computation: first order, in the middle of its stroke at this time [s].
middle() {
  awk -v e="$1" 'BEGIN { d = 0.2; g = 9.81; H = e * d
    print ((3.8 + e) / sqrt(3 * H / (4 * d * d * d)) + sqrt(4 * H * d / 3)) / sqrt(g * (d + H)) }'
}
# wall NAME H OPTION ...: a run of movable_seawall, small ones side by side.
wall() {
  name=$1 height=$2
  shift 2
  run "$name" movable_seawall --method "$method" --dx $coarse --height-ratio "$height" --threads 1 "$@"
}
# with_exact NAME H FILE OPTION ...: the piston moves as in a file of the exact computation.
with_exact() {
  name=$1 height=$2 file=$3
  shift 3
  wall "$name" "$height" --motion "$measured/computed_liang_tank_H$file.csv" "$@"
}
corners() {
  [ "$report" = 1 ] && return 0
  # shellcheck disable=SC2086  # a list of words
  "$build/examples/seawall_study" --method "$method" $study_options --out "$study_csv" "$@" || true
}
{
  for h in $heights; do
    case $h in
      0.1 | 0.3) with_exact fixed_$h $h ${h}_fixed --fixed ;;
      0.5) with_exact fixed_$h $h ${h}_fixed --fixed --pictures 41 ;;
      *) wall fixed_$h $h --fixed --paddle-middle "$(middle $h)" ;;
    esac
  done
  for d in 0.2 0.3 0.4; do wall static_$d 0.01 --fixed --depth $d --paddle-start 100 --end 1; done
  with_exact wall_0.5_250_10 0.5 0.5_m250_k10 --mass 250 --stiffness 10 --pictures 41
  with_exact wall_0.5_500_10 0.5 0.5_m250_k10 --mass 500 --stiffness 10
  with_exact wall_0.5_50_500 0.5 0.5_m50_k500 --mass 50 --stiffness 500
  with_exact wall_0.3_50_100 0.3 0.3_m50_k100 --mass 50 --stiffness 100
  with_exact wall_0.3_100_100 0.3 0.3_m50_k100 --mass 100 --stiffness 100
} &
{
  for k in $stiffnesses; do wall series_0.3_50_$k 0.3 --mass 50 --stiffness $k --paddle-middle 1; done
  for m in $masses; do wall series_0.5_${m}_500 0.5 --mass "$m" --stiffness 500 --paddle-middle 1; done
  for h in 0.2 0.3 0.4 0.6; do wall series_${h}_250_500 $h --mass 250 --stiffness 500 --paddle-middle 1; done
} &
wait
corners --heights 0.2,0.6 --stiffnesses 0.01,1e7 --masses 50,500
[ "$study" = 0 ] || corners

mkdir -p "$out/images"
rm -f "$out"/images/*.png
plot -e "out='$out'; measured='$measured'; images='$out/images'" "$root/tests/validation/liang.gp"
plot -e "study='$study_csv'; images='$out/images'" "$examples/seawall_study_plots.gp"
for image in displacement force run_up; do
  [ ! -e "$out/images/seawall_$image.png" ] || mv "$out/images/seawall_$image.png" "$out/images/liang_study_$image.png"
done

# marked VALUE EXACT: a figure, with its error where that is more than 5 %.
marked() {
  awk -v x="$1" -v e="$2" 'BEGIN {
    if (x !~ /^[-+.]?[0-9]/) { print x == "" || x == "null" ? "-" : x; exit }
    if (e !~ /^[-+.]?[0-9]/ || (e < 0.001 && e > -0.001)) { printf "%.4g\n", x; exit }
    r = 100 * (x / e - 1)
    format = r > 5 || r < -5 ? "**%.4g** (%+.0f %%)\n" : "%.4g\n"
    printf format, x, r }'
}
# line QUANTITY PAPER EXACT OURS ...: a row of a table, "-" for what there is not.
line() {
  quantity=$1 exact=$3
  printf '| %s | %s | %s |' "$quantity" "$(marked "$2" "$exact")" "$(marked "$exact" "")"
  shift 3
  for ours in "$@"; do printf ' %s |' "$(marked "$ours" "$exact")"; done
  echo
}
# printed H K M COLUMN [WITH]: of the paper's text; force 4, its time 5, run-up 6, 7, displacement, force, level at 4 s
# 8, 9, 10, onset 11. WITH: of the row that has this column too, where the paper tells a case twice.
printed() {
  awk -F, -v h="$1" -v k="$2" -v m="$3" -v c="$4" -v w="${5:-$4}" \
    '$1 == h && $2 == k && $3 == m && $c != "-" && $w != "-" { print $c; exit }' "$paper"
}
# of RUN KEY: a figure of its summary.
of() { figure "$out/$1.json" "$2"; }
# series FILE COLUMN WHAT ...: by series.awk or liang.awk.
series() {
  file=$1 column=$2 what=$3
  shift 3
  case $what in at | mean | away | second | second_at) script=liang.awk ;; *) script=series.awk ;; esac
  [ ! -e "$file" ] || awk -f "$root/tests/validation/$script" -v column="$column" -v what="$what" "$@" "$file"
}
# of the exact tank FILE and of RUN, over static force and depths: force, run_up (level), wall (displacement).
exact() {
  file=$measured/computed_liang_tank_H$1.csv of=$2 what=$3
  shift 3
  case $of in
    force) series "$file" 8 "$what" -v window=0.0714 "$@" ;;
    run_up) series "$file" 7 "$what" -v scale=5 "$@" ;;
    wall) series "$file" 4 "$what" -v offset=2.5 -v scale=5 "$@" ;;
    paddle) series "$file" 6 "$what" "$@" ;;
    crest) series "$file" 10 "$what" "$@" ;;
    crest_at) series "$file" 11 "$what" "$@" ;;
  esac
}
ours() {
  folder=$out/$1 of=$2 what=$3
  shift 3
  case $of in
    force) series "$folder/force.csv" 2 "$what" -v scale=0.005096840 -v window=0.0714 "$@" ;;
    run_up) series "$folder/run_up.csv" 2 "$what" -v offset=0.2 -v scale=5 -v window=0.0143 "$@" ;;
    wall) series "$folder/wall.csv" 2 "$what" -v scale=5 "$@" ;;
  esac
}
# surface RUN TENTHS paddle|crest|crest_at: of the picture at a tenth of a second, m above still water: level at the
# piston; highest level beyond it; its place.
surface() {
  picture=$out/$1/picture_$(printf %03d "$2").txt
  [ -e "$picture" ] || return 0
  awk -v what="$3" -v d=0.2 '
    /^# t_star/ { s = $5 }
    /^[-0-9]/ { x[n] = $1; y[n++] = $2 + s / 2; if (n == 1 || $1 < left) left = $1 }
    END {
      for (i = 0; i < n; i++) {
        if (x[i] < left + 1.5 * s) { if (y[i] > paddle) paddle = y[i] }
        else if (y[i] > crest) { crest = y[i]; crest_at = x[i] }
      }
      print what == "paddle" ? (paddle - 1) * d : what == "crest" ? (crest - 1) * d : crest_at * d }' "$picture"
}
over_second() { awk -v t="$1" 'BEGIN { if (t ~ /[0-9]/) print t * sqrt(9.81 / 0.2) }'; }
added() { awk -v a="$1" -v b="$2" 'BEGIN { if (a ~ /[0-9]/ && b ~ /[0-9]/) print a + b }'; }
# wave H COLUMN: of the exact wave of permanent form at a wall; run-up 2, forces 5 and 7, their times 6 and 8.
wave() {
  awk -F, -v h="$1" -v c="$2" '/^[0-9]/ && $1 + 0 == h && $c != "nan" { print $c }' "$measured/computed_solitary_wall_runup_force_summary.csv"
}
# study_row H K M COLUMN: of the parameter study; force 4, run-up 6, displacement 9.
study_row() {
  [ ! -e "$study_csv" ] || awk -F, -v h="$1" -v k="$2" -v m="$3" -v c="$4" \
    '/^[0-9]/ && $1 == h && $2 == k && $3 == m && $c != "nan" { print $c }' "$study_csv"
}
# rise H M: run-up at the stiffest over that at the softest spring, per cent.
rise() {
  awk -v a="$(study_row "$1" 0.01 "$2" 6)" -v b="$(study_row "$1" 10000000 "$2" 6)" \
    'BEGIN { if (a > 0 && b > 0) print 100 * (b / a - 1) }'
}
# spread COLUMN K_REFERENCE K_FROM K_TO: the largest distance of a figure from that at K_REFERENCE, per cent, over all
# waves and masses of the study.
spread() {
  [ ! -e "$study_csv" ] || awk -F, -v c="$1" -v r="$2" -v lo="$3" -v hi="$4" '
    /^[0-9]/ && $c != "nan" { v[$1, $3, $2] = $c }
    END {
      for (i in v) {
        split(i, part, SUBSEP)
        if (part[3] + 0 < lo || part[3] + 0 > hi || !((part[1], part[2], r) in v) || v[part[1], part[2], r] == 0) continue
        e = 100 * (v[i] / v[part[1], part[2], r] - 1); if (e < 0) e = -e
        if (part[3] + 0 != r + 0) n++
        if (e > most) most = e
      }
      if (n) print most + 0 }' "$study_csv"
}
most_displacement() {
  [ ! -e "$study_csv" ] || awk -F, -v lo="$1" '/^[0-9]/ && $2 + 0 >= lo && $9 != "nan" { n++; if ($9 + 0 > most) most = $9 + 0 }
    END { if (n) print most + 0 }' "$study_csv"
}
seconds_of_study() {
  awk -F, '/^[0-9]/ { print $14 }' "$study_csv" 2>/dev/null | sort -n | awk '{ s[NR] = $1; all += $1 }
    END { if (NR) printf "One takes %.0f s of one thread (median of them, the machine shared with other work), all of them %.2g hours of one thread.\n", s[int((NR + 1) / 2)], all / 3600 }'
}
rows_of_study() { [ ! -e "$study_csv" ] || grep -c "^[0-9].*,$1," "$study_csv" || true; }
{
  cat <<TEXT
# Validation: every number of Liang et al. (2017)

This page is written by \`make liang\` and \`tests/validation/liang.sh build/liang --report --update\`: every figure of ours comes out of the runs below.
**Bold**, with its error, is whatever is more than 5 % away from the exact solution, the paper's numbers as ours; where there is no exact solution nothing is marked.

Liang, Jian, Shao, Chen and Yang (2017), J. Fluids Struct. 69, 72-88, compute waves at a seawall by incompressible SPH; they have no experiment of a wall that moves.
The tank: still depth h = 0.2 m, 2.5 m from piston to seawall; here dx = $(of fixed_0.5 dx_m) m, method \`$method\`.
F_static = rho g h²/2 = 196.2 N/m, F_thr = 1.1 F_static; m in kg/m, k in N/m per m, times in s from the start, X the displacement.
Exact means potential flow without approximation, by boundary elements, in the same tank with the same paddle and the wall's printed rule (\`tests/data/computed_liang_tank_*\`), or of a wave of permanent form (\`computed_solitary_wall_*\`).
Our forces, and those of the exact tank, are means over half of sqrt(h/g).

The paper does not say when its piston starts.
Runs that have an exact solution beside them move it as that does (in the middle of its stroke at $(middle 0.5 | cut -c1-5) s for H/h = 0.5, $(middle 0.3 | cut -c1-5) s for 0.3); all others have the middle at 1 s, where the run-up times of the paper put it.

## Water at rest

Force on a wall at rest over F_static, from 0.3 s to 1 s; the paper finds 1, and oscillations until 0.3 s.

| depth [m] | mean | largest distance from 1 |
|---|---|---|
TEXT
  for d in 0.2 0.3 0.4; do
    scale=$(awk -v d=$d 'BEGIN { print 1 / (0.5 * 1000 * 9.81 * d * d) }')
    printf '| %s | %s | %s |\n' $d "$(marked "$(series "$out/static_$d/force.csv" 2 mean -v scale="$scale" -v from=0.3 -v to=1)" 1)" \
      "$(marked "$(series "$out/static_$d/force.csv" 2 away -v scale="$scale" -v from=0.3 -v to=1 -v level=1)" '')"
  done
  cat <<'TEXT'

## Application I: fixed wall

Run-up R/h. "Exact, tank" has the paddle of the paper, whose wave is not quite of permanent form; "exact, wave" is such a wave; ours is compared with the former where there is one, the formula 2 e + e²/2 + 3 e³/4, e = H/h, of Su and Mirie (1980) with the latter.

| H/h | Su and Mirie | exact, wave | exact, tank | here | Liang et al. (2017) |
|---|---|---|---|---|---|
TEXT
  for h in $heights; do
    e=$(exact ${h}_fixed run_up most)
    formula=$(awk -v e=$h 'BEGIN { print 2 * e + e * e / 2 + 3 * e * e * e / 4 }')
    reference=${e:-$(wave $h 2)}
    printf '| %s | %s | %s | %s | %s | %s |\n' $h "$(marked "$formula" "$(wave $h 2)")" "$(marked "$(wave $h 2)" '')" "$(marked "$e" '')" \
      "$(marked "$(of fixed_$h run_up_over_d)" "$reference")" "$(marked "$(printed $h fixed fixed 6)" "$reference")"
  done
  cat <<'TEXT'

Largest force over F_static, and whether there is a second maximum, 1 to 3.5 sqrt(h/g) from the first and with a dip of 1 % between the two: the paper sees one below H/h = 0.4 and two above, potential flow two from 0.43 on.
Distances in time are in sqrt(h/g).

| H/h | exact, wave | exact, tank | here | Liang et al. (2017) | second maximum: exact, wave | here | from the first: exact, wave | here |
|---|---|---|---|---|---|---|---|---|
TEXT
  for h in $heights; do
    e=$(exact ${h}_fixed force most)
    reference=${e:-$(wave $h 5)}
    apart=$(awk -v a="$(wave $h 6)" -v b="$(wave $h 8)" 'BEGIN { if (a != "" && b != "") print b - a }')
    printf '| %s | %s | %s | %s | %s | %s | %s | %s | %s |\n' $h "$(marked "$(wave $h 5)" '')" "$(marked "$e" '')" \
      "$(marked "$(of fixed_$h force_max_over_static)" "$reference")" "$(marked "$(printed $h fixed fixed 4)" "$reference")" \
      "$(marked "$(wave $h 7)" '')" "$(marked "$(ours fixed_$h force second)" "$(wave $h 7)")" "$(marked "$apart" '')" \
      "$(marked "$(over_second "$(ours fixed_$h force second_at)")" '')"
  done
  cat <<'TEXT'

![forces on the fixed wall](images/liang_fixed.png)

| H/h = 0.5, fixed | Liang et al. (2017) | exact | here |
|---|---|---|---|
TEXT
  e=0.5_fixed r=fixed_0.5
  line '1.00 s: level of the water at the paddle [m]' 0.30 "$(added 0.2 "$(exact $e paddle at -v from=1)")" "$(added 0.2 "$(surface $r 10 paddle)")"
  line '1.30 s: crest at x [m]' 0.80 "$(exact $e crest_at at -v from=1.3)" "$(surface $r 13 crest_at)"
  line '... its height [m]' 0.10 "$(exact $e crest at -v from=1.3)" "$(surface $r 13 crest)"
  line 'R/h' "$(printed 0.5 fixed fixed 6)" "$(exact $e run_up most)" "$(of $r run_up_over_d)"
  line '... by "0.27 m"' 1.35 "$(exact $e run_up most)" "$(of $r run_up_over_d)"
  line '... when' 2.40 "$(exact $e run_up most_at)" "$(of $r run_up_time_s)"
  line 'largest force / F_static' "$(printed 0.5 fixed fixed 4)" "$(exact $e force most)" "$(of $r force_max_over_static)"
  cat <<'TEXT'

## Application II: movable wall

### The illustrated case

The last column is a wall twice as heavy.

| H/h = 0.5, m = 250, k = 10 | Liang et al. (2017) | exact | here | here, m = 500 |
|---|---|---|---|---|
TEXT
  e=0.5_m250_k10 r=wall_0.5_250_10 twice=wall_0.5_500_10
  table_line() { # QUANTITY PAPER COLUMN WHAT ...
    quantity=$1 value=$2 column=$3
    shift 3
    line "$quantity" "$value" "$(exact $e "$column" "$@")" "$(ours $r "$column" "$@")" "$(ours $twice "$column" "$@")"
  }
  table_line 'force above F_thr from' 2.00 force rises -v level=1.1
  table_line 'wall has moved 0.001 h at' "$(printed 0.5 10 250 11)" wall rises -v level=0.001
  line 'largest force / F_static' "$(printed 0.5 10 250 4)" "$(exact $e force most)" "$(of $r force_max_over_static)" "$(of $twice force_max_over_static)"
  line '... when' "$(printed 0.5 10 250 5)" "$(exact $e force most_at)" "$(of $r force_max_time_s)" "$(of $twice force_max_time_s)"
  less() { awk -v a="$1" -v b="$2" 'BEGIN { if (a > 0 && b > 0) print 100 * (1 - a / b) }'; }
  line '... less than on the fixed wall [%]' 8.72 "$(less "$(exact $e force most)" "$(exact 0.5_fixed force most)")" \
    "$(less "$(of $r force_max_over_static)" "$(of fixed_0.5 force_max_over_static)")" "$(less "$(of $twice force_max_over_static)" "$(of fixed_0.5 force_max_over_static)")"
  line 'R/h' "$(printed 0.5 10 250 6)" "$(exact $e run_up most)" "$(of $r run_up_over_d)" "$(of $twice run_up_over_d)"
  line '... when' "$(printed 0.5 10 250 7)" "$(exact $e run_up most_at)" "$(of $r run_up_time_s)" "$(of $twice run_up_time_s)"
  table_line 'force below F_static from' 2.90 force falls -v level=1 -v from=2.5
  table_line 'X/h at 4 s' "$(printed 0.5 10 250 8)" wall at -v from=4
  table_line '... by "x = 2.95 m"' 2.25 wall at -v from=4
  table_line 'force / F_static at 4 s' "$(printed 0.5 10 250 9)" force at -v from=4
  table_line 'level at the wall / h at 4 s' "$(printed 0.5 10 250 10)" run_up at -v from=4
  line 'crest at 2.40 s less that at 2.80 s [m]' 0.1 \
    "$(added "$(exact $e crest at -v from=2.4)" "-$(exact $e crest at -v from=2.8)")" "$(added "$(surface $r 24 crest)" "-$(surface $r 28 crest)")" -
  line 'run-up at the paddle at 4.0 s [m]' 0.07 "$(exact $e paddle at -v from=4)" "$(surface $r 40 paddle)" -
  cat <<'TEXT'

![the illustrated case](images/liang_illustrated.png)

### Stiffness: H/h = 0.3, m = 50

Exact times are moved by the difference of the paddles; exact "k >= 1e4" is a fixed wall.

| quantity | Liang et al. (2017) | exact | here |
|---|---|---|---|
TEXT
  back=$(added 1 "-$(middle 0.3)")
  soft=series_0.3_50_10 mid=series_0.3_50_1000 stiff=series_0.3_50_10000
  line 'k = 10: largest force' "$(printed 0.3 '<=10' 50 4)" - "$(of $soft force_max_over_static)"
  line '... R/h' "$(printed 0.3 '<=10' 50 6)" - "$(of $soft run_up_over_d)"
  line '... X/h at 4 s, domain a third longer' 4.2 - "$(of $soft displacement_end_over_d)"
  e=0.3_m50_k100
  line 'k = 100: largest force' - "$(exact $e force most)" "$(of series_0.3_50_100 force_max_over_static)"
  line '... R/h' - "$(exact $e run_up most)" "$(of series_0.3_50_100 run_up_over_d)"
  line '... largest X/h' 1.64 "$(exact $e wall most)" "$(of series_0.3_50_100 displacement_max_over_d)"
  line '... when' 3.5 "$(added "$(exact $e wall most_at)" "$back")" "$(of series_0.3_50_100 displacement_max_time_s)"
  line '... X/h at 4 s' "$(printed 0.3 100 50 8)" - "$(of series_0.3_50_100 displacement_end_over_d)"
  line '... the same with the exact paddle' - "$(exact $e wall at -v from=4)" "$(ours wall_0.3_50_100 wall at -v from=4)"
  line 'k = 1e3: largest X/h' 0.55 - "$(of $mid displacement_max_over_d)"
  line '... when' 2.88 - "$(of $mid displacement_max_time_s)"
  line '... back at its place' 3.5 - "$(ours $mid wall falls -v level=0.01 -v from=3)"
  line '... second maximum of the force' 'twin peaks' - "$(ours $mid force second -v reach=1)"
  line 'k = 1e4: largest force' "$(printed 0.3 '>=1e4' 50 4)" "$(exact 0.3_fixed force most)" "$(of $stiff force_max_over_static)"
  line '... R/h' "$(printed 0.3 '>=1e4' 50 6)" "$(exact 0.3_fixed run_up most)" "$(of $stiff run_up_over_d)"
  line '... largest X/h' 0 - "$(of $stiff displacement_max_over_d)"
  line '... force at 4 s' "$(printed 0.3 '>=1e4' 50 9)" - "$(ours $stiff force at -v from=4)"
  line '... level at 4 s / h' "$(printed 0.3 '>=1e4' 50 10)" - "$(ours $stiff run_up at -v from=4)"
  cat <<'TEXT'

![stiffness](images/liang_stiffness.png)

### Mass: H/h = 0.5, k = 500

| largest force / F_static | Liang et al. (2017) | exact | here |
|---|---|---|---|
TEXT
  for m in $masses; do
    case $m in 375 | 500) of_paper='>=375' ;; *) of_paper=$m ;; esac
    e=
    [ "$m" != 50 ] || e=$(exact 0.5_m50_k500 force most)
    line "m = $m" "$(printed 0.5 500 $of_paper 4)" "${e:--}" "$(of series_0.5_${m}_500 force_max_over_static)"
  done
  cat <<'TEXT'

With m = 50 and the exact paddle:

| H/h = 0.5, m = 50, k = 500 | Liang et al. (2017) | exact | here |
|---|---|---|---|
TEXT
  e=0.5_m50_k500 r=wall_0.5_50_500
  line 'largest force / F_static' 2.10 "$(exact $e force most)" "$(of $r force_max_over_static)"
  line 'R/h' - "$(exact $e run_up most)" "$(of $r run_up_over_d)"
  line 'largest X/h' - "$(exact $e wall most)" "$(of $r displacement_max_over_d)"
  line '... when' - "$(exact $e wall most_at)" "$(of $r displacement_max_time_s)"
  cat <<'TEXT'

![mass](images/liang_mass.png)

### Wave height: m = 250, k = 500

There is no exact solution of these; the exact fixed wall bounds force and run-up from above.

| H/h | | onset | largest force | when | R/h | when | force / exact, fixed |
|---|---|---|---|---|---|---|---|
TEXT
  for h in 0.6 0.5 0.4 0.3 0.2; do
    r=series_${h}_250_500
    over() { awk -v a="$1" -v b="$(wave $h 5)" 'BEGIN { if (a ~ /[0-9]/ && b > 0) print a / b }'; }
    printf '| %s | Liang et al. (2017) | %s | %s | %s | %s | %s | %s |\n' $h "$(printed $h 500 250 11 11)" "$(printed $h 500 250 4 11)" \
      "$(printed $h 500 250 5 11)" "$(printed $h 500 250 6 11)" "$(printed $h 500 250 7 11)" "$(marked "$(over "$(printed $h 500 250 4 11)")" '')"
    printf '| | here | %s | %s | %s | %s | %s | %s |\n' "$(marked "$(of $r moves_from_s)" '')" "$(marked "$(of $r force_max_over_static)" '')" \
      "$(marked "$(of $r force_max_time_s)" '')" "$(marked "$(of $r run_up_over_d)" '')" "$(marked "$(of $r run_up_time_s)" '')" \
      "$(marked "$(over "$(of $r force_max_over_static)")" '')"
  done
  cat <<'TEXT'

![wave height](images/liang_height.png)

### Twice the mass

The paper's walls move about half as far as their equation makes them, and get larger forces.
Beside them a wall of that mass, and one twice as heavy:

| case | Liang et al. (2017) | exact | here | here, twice the mass |
|---|---|---|---|---|
TEXT
  e=0.5_m250_k10 r=wall_0.5_250_10 twice=wall_0.5_500_10
  line 'H/h = 0.5, m = 250, k = 10: largest force' "$(printed 0.5 10 250 4)" "$(exact $e force most)" "$(of $r force_max_over_static)" "$(of $twice force_max_over_static)"
  line '... R/h' "$(printed 0.5 10 250 6)" "$(exact $e run_up most)" "$(of $r run_up_over_d)" "$(of $twice run_up_over_d)"
  line '... X/h at 4 s' "$(printed 0.5 10 250 8)" "$(exact $e wall at -v from=4)" "$(ours $r wall at -v from=4)" "$(ours $twice wall at -v from=4)"
  e=0.5_m50_k500 r=series_0.5_50_500 twice=series_0.5_100_500
  line 'H/h = 0.5, m = 50, k = 500: largest force' "$(printed 0.5 500 50 4)" "$(exact $e force most)" "$(of $r force_max_over_static)" "$(of $twice force_max_over_static)"
  r=series_0.5_250_500 twice=series_0.5_500_500
  line 'H/h = 0.5, m = 250, k = 500: largest force' "$(printed 0.5 500 250 4)" - "$(of $r force_max_over_static)" "$(of $twice force_max_over_static)"
  line '... R/h' "$(printed 0.5 500 250 6)" - "$(of $r run_up_over_d)" "$(of $twice run_up_over_d)"
  e=0.3_m50_k100 r=wall_0.3_50_100 twice=wall_0.3_100_100
  line 'H/h = 0.3, m = 50, k = 100: largest X/h' 1.64 "$(exact $e wall most)" "$(of $r displacement_max_over_d)" "$(of $twice displacement_max_over_d)"
  cat <<TEXT

## Collective effects

Of the parameter study (\`examples/seawall_study\`): $(rows_of_study SPH_OK) of 300 runs are done, $(awk -F, '/^[0-9]/ && $15 != "SPH_OK"' "$study_csv" 2>/dev/null | wc -l | tr -d ' ') failed.
$(seconds_of_study)
k* = k/(rho g h²), m* = m/(rho h²).

| quantity | Liang et al. (2017) | here |
|---|---|---|
TEXT
  short() { printf '| %s | %s | %s |\n' "$1" "$2" "$(marked "$3" '')"; }
  short 'R, k = 1e7 above k = 0.01 [%]: H/h = 0.2, m* = 1.25' 37.2 "$(rise 0.2 50)"
  short '... H/h = 0.6, m* = 1.25' 43.2 "$(rise 0.6 50)"
  short '... H/h = 0.2, m* = 12.5' 6.9 "$(rise 0.2 500)"
  short '... H/h = 0.6, m* = 12.5' 7.4 "$(rise 0.6 500)"
  short 'log k* < -1.59: largest change of X from k = 0.01 [%]' 'very little' "$(spread 9 0.01 0.01 10)"
  short 'log k* < 0.41: largest change of the force from k = 0.01 [%]' flat "$(spread 4 0.01 0.01 1000)"
  short '... of R' flat "$(spread 6 0.01 0.01 1000)"
  short 'log k* > 2.41: largest change of the force from k = 1e7 [%]' flat "$(spread 4 10000000 100000 1e9)"
  short '... of R' flat "$(spread 6 10000000 100000 1e9)"
  short '... largest X/h' 'virtually 0' "$(most_displacement 100000)"
  cat <<'TEXT'

![largest displacement](images/liang_study_displacement.png)
![largest force](images/liang_study_force.png)
![largest run-up](images/liang_study_run_up.png)
TEXT
} >"$out/$page"
finish
