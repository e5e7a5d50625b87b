#!/bin/sh
# Solitary waves at walls: vertical, inclined, on a spring, beside the exact potential flow. Writes
# FOLDER/validation_waves.md with figures, bars and plots.
#
#   waves.sh FOLDER [--quick] [--report] [--update]
#
# --quick    coarse and short, to try the script itself; the figures mean nothing
# --report   write the page from the runs that are in FOLDER already
# --update   copy the page to docs/ and its plots to docs/images/
# BUILD in the environment is where the examples were built.
set -eu
page=validation_waves.md wants=solitary_wave
# shellcheck source=tests/validation/runs.sh
. "$(dirname "$0")/runs.sh"

ratios='0.1 0.2 0.3 0.4 0.5 0.6'
methods='improved-shepard mls-linear mls-quadratic sfdi'
coarse='' coarse_tank='' coarse_waves='' fine_waves='--dx 0.0035714286'
[ "$quick" = 1 ] && coarse='--dx 0.025 --length 6' coarse_tank='--dx 0.025' coarse_waves=--quick fine_waves=--quick
tank="computed_liang_tank_H"

# Small runs are faster side by side than on two threads.
one() { run "$@" --threads 1; }
# shellcheck disable=SC2086  # lists of words
{
  for h in $ratios; do one vertical_$h solitary_wave --height-ratio $h $coarse; done
  for h in 0.3 0.6; do one inclined_$h solitary_wave --wall inclined --height-ratio $h $coarse; done
  one regular_fine regular_waves $fine_waves
} &
# shellcheck disable=SC2086
{
  for h in $ratios; do one paddle_$h solitary_wave --start paddle --height-ratio $h --length 5 $coarse; done
  for m in $methods; do
    [ $m = improved-shepard ] || one inclined_0.6_$m solitary_wave --wall inclined --height-ratio 0.6 --interpolator $m $coarse
  done
  one fixed_0.5 movable_seawall --fixed --motion "$measured/${tank}0.5_fixed.csv" $coarse_tank
  one fixed_0.3 movable_seawall --fixed --height-ratio 0.3 --motion "$measured/${tank}0.3_fixed.csv" $coarse_tank
  one wall_0.5_250_10 movable_seawall --mass 250 --stiffness 10 --motion "$measured/${tank}0.5_m250_k10.csv" $coarse_tank
  one wall_0.5_500_10 movable_seawall --mass 500 --stiffness 10 --motion "$measured/${tank}0.5_m250_k10.csv" $coarse_tank
  one wall_printed movable_seawall --rule printed --mass 250 --stiffness 10 --motion "$measured/${tank}0.5_m250_k10.csv" $coarse_tank
  one wall_0.5_50_500 movable_seawall --mass 50 --stiffness 500 --motion "$measured/${tank}0.5_m50_k500.csv" $coarse_tank
  one wall_0.3_50_100 movable_seawall --height-ratio 0.3 --mass 50 --stiffness 100 --motion "$measured/${tank}0.3_m50_k100.csv" $coarse_tank
  one regular_stokes2 regular_waves $coarse_waves
  one regular_airy regular_waves --theory airy $coarse_waves
  one regular_flap regular_waves --theory airy --paddle flap $coarse_waves
  one regular_open regular_waves --rate 0 $coarse_waves
  one regular_jonswap regular_waves --theory jonswap --periods 16 $coarse_waves
}
wait

mkdir -p "$out/images"
rm -f "$out"/images/*.png
plot -e "out='$out'; measured='$measured'; images='$out/images'" "$root/tests/validation/waves.gp"

# near QUANTITY RUN KEY EXACT PERCENT TEXT: a figure within so many per cent of the exact one.
near() {
  row "$1" "$(figure "$out/$2.json" "$3")" "$(scaled "$(awk -v p="$5" 'BEGIN { print 1 - p / 100 }')" "$4")" \
    "$(scaled "$(awk -v p="$5" 'BEGIN { print 1 + p / 100 }')" "$4")" "$6"
}
# told QUANTITY RUN KEY TEXT: a figure without a bar.
told() { row_without_bar "$1" "$(figure "$out/$2.json" "$3")" "$4"; }
# series FILE COLUMN WHAT ...: of a column over the time in column T (1), by series.awk; times of runs are means
# over half of sqrt(d/g), as the summaries have them.
series() {
  file=$1 column=$2 what=$3
  shift 3
  awk -f "$root/tests/validation/series.awk" -v column="$column" -v what="$what" "$@" "$file"
}
# exact FILE COLUMN: the largest value. summary H COLUMN: of the table of vertical walls.
exact() { awk -F, -v c="$2" '/^[-0-9]/ && (n++ == 0 || $c + 0 > most) { most = $c + 0 } END { print most }' "$measured/$1"; }
summary() { awk -F, -v h="$1" -v c="$2" '/^[0-9]/ && $1 + 0 == h { print $c }' "$measured/computed_solitary_wall_runup_force_summary.csv"; }
# displacement FILE WHAT: of the wall from 2.5 m, in depths of 0.2 m, largest or last.
displacement() {
  awk -F, -v what="$2" '/^[0-9]/ { x = ($4 - 2.5) / 0.2; if (x > most) most = x; last = x }
    END { print what == "last" ? last : most }' "$measured/$1"
}
# tank WHERE force|run_up|bed|wall WHAT ...: of the tank of d = 0.2 m, over static force, depths and static pressure.
# WHERE: a file of the exact computation, or a run, whose peaks are those of its summary.
tank() {
  where=$1 of=$2 what=$3
  shift 3
  case $where/$of/$what in
    *.csv/force/*) series "$measured/$where" 8 "$what" "$@" ;;
    *.csv/run_up/*) series "$measured/$where" 7 "$what" -v scale=5 "$@" ;;
    *.csv/bed/*) series "$measured/$where" 12 "$what" "$@" ;;
    *.csv/wall/*) series "$measured/$where" 4 "$what" -v offset=2.5 -v scale=5 "$@" ;;
    */force/most) figure "$out/$where.json" force_max_over_static ;;
    */force/most_at) figure "$out/$where.json" force_max_time_s ;;
    */run_up/most) figure "$out/$where.json" run_up_over_d ;;
    */run_up/most_at) figure "$out/$where.json" run_up_time_s ;;
    */force/*) series "$out/$where/force.csv" 2 "$what" -v scale=0.005096840 -v window=0.0714 "$@" ;;
    */run_up/*) series "$out/$where/run_up.csv" 2 "$what" -v offset=0.2 -v scale=5 "$@" ;;
    */bed/*) series "$out/$where/bed.csv" 2 "$what" -v window=0.0714 "$@" ;;
    */wall/*) series "$out/$where/wall.csv" 2 "$what" -v scale=5 "$@" ;;
  esac
}
# beside QUANTITY PRINTED ... -- force|run_up|bed|wall WHAT ...: a row with the papers' figures and those of $wheres.
beside() {
  quantity=$1 papers=
  while shift && [ "$1" != -- ]; do papers="$papers $1 |"; done
  shift
  printf '| %s |%s' "$quantity" "$papers"
  for where in $wheres; do awk -v x="$(tank "$where" "$@")" 'BEGIN { printf " %s |", x == "" ? "-" : sprintf("%.4g", x) }'; done
  echo
}
printed() {
  wheres="${tank}0.5_fixed.csv fixed_0.5"
  echo '| H/d = 0.5, wall fixed | Liang et al. (2017) | exact | here |'
  echo '|---|---|---|---|'
  beside 'largest force' 2.99 -- force most
  beside '... when' - -- force most_at
  beside 'R/d' '1.21, 1.35' -- run_up most
  beside '... when' 2.40 -- run_up most_at
  wheres="${tank}0.5_m250_k10.csv wall_0.5_250_10 wall_printed wall_0.5_500_10"
  cat <<'TEXT'

| H/d = 0.5, m = 250 kg/m, k = 10 N/m | Liang et al. (2017) | Huang et al. (2019) | exact | here | here, as printed | here, m = 500 |
|---|---|---|---|---|---|---|
TEXT
  beside 'force above F_thr from' 2.00 - -- force rises -v level=1.1
  beside 'wall has moved 0.001 d at' - '2.00 to 2.20' -- wall rises -v level=0.001
  beside 'largest force' 2.73 - -- force most
  beside '... when' 2.24 - -- force most_at
  beside 'R/d' 1.04 - -- run_up most
  beside '... when' 2.40 - -- run_up most_at
  beside 'largest pressure at the foot, when' - 2.4 -- bed most_at
  beside 'force below the static one from' 2.90 - -- force falls -v level=1 -v from=2.5
  beside 'displacement / d at 4 s' 2.16 2.3 -- wall last
  beside 'force at 4 s' 0.63 - -- force last
  beside 'level at the wall / d at 4 s' -0.18 - -- run_up last
  wheres="${tank}0.3_m50_k100.csv wall_0.3_50_100"
  cat <<'TEXT'

| other cases | Liang et al. (2017) | exact | here |
|---|---|---|---|
TEXT
  beside 'H/d = 0.3, m = 50, k = 100: largest displacement / d' 1.64 -- wall most
  beside '... when' 3.5 -- wall most_at
  beside '... displacement / d at 4 s' 1.36 -- wall last
  wheres="${tank}0.5_m50_k500.csv wall_0.5_50_500"
  beside 'H/d = 0.5, m = 50, k = 500: largest force' 2.10 -- force most
  wheres="${tank}0.3_fixed.csv fixed_0.3"
  beside 'H/d = 0.3, stiff (here fixed): largest force' 2.40 -- force most
  beside '... R/d' 0.75 -- run_up most
}
# cells NAME VALUE ...: a row of a table of figures alone, "" where there is none.
cells() {
  printf '| %s |' "$1"
  shift
  for value in "$@"; do
    case $value in
      [-+.0-9]*) awk -v x="$value" 'BEGIN { printf " %.4g |", x }' ;;
      *) printf ' %s |' "$value" ;;
    esac
  done
  echo
}
{
  cat <<TEXT
# Validation: waves and seawalls

This page is written by \`make validate-waves\` and \`tests/validation/waves.sh build/waves --report --update\`: every figure comes out of the runs below, with the bar that it has to stay in.
A figure outside its bar says **no**; nothing is left out.
What the figures mean is in [examples.md](examples.md).

Exact means potential flow without approximation, computed by boundary elements and conformal maps (files \`computed_*\` in \`tests/data\`).
δ-SPH with fixed ghosts by improved Shepard, Wendland C2 kernel with h = 2 dx, c0 = 10 sqrt(g (d + H)), alpha = 0.01, 25 particles a depth unless said otherwise.
Forces and pressures are means over half of sqrt(d/g): sound runs from surface to bed and back in about that time, and is seen in the plots. Run-up is counted from the level that its gauge shows before the wave is there.

## Vertical wall

A flume of d = 0.25 m, 10 m long, dx = $(figure "$out/vertical_0.3.json" dx_m) m; the exact wave is there at t = 0, its crest 20 d before the wall.
Run-up R and force F/(rho g d^2/2) are compared up to H/d = 0.4; steeper jets are thinner than the spacing, and are reported.

TEXT
  for h in 0.1 0.2 0.3 0.4 0.5 0.6; do
    case $h in
      0.5 | 0.6)
        told "H/d = $h: R/d" vertical_$h run_up_over_d "exact: $(summary $h 2)"
        told "H/d = $h: largest force" vertical_$h force_max_over_static "exact: $(summary $h 5)"
        ;;
      *)
        near "H/d = $h: R/d" vertical_$h run_up_over_d "$(summary $h 2)" 5 "exact: $(summary $h 2)"
        near "H/d = $h: largest force" vertical_$h force_max_over_static "$(summary $h 5)" 5 "exact: $(summary $h 5)"
        ;;
    esac
    near "H/d = $h: celerity / exact" vertical_$h celerity_over_theory 1 1.5 'exact'
    row "H/d = $h: particles that left the flume" "$(figure "$out/vertical_$h.json" particles_lost)" 0 0 'none'
  done
  table
  cat <<TEXT
![force on the wall](images/waves_force.png)
![run-up](images/waves_run_up.png)

## Wave maker

The same waves made by a piston that moves as the exact wave's water, at a gauge 5 d from it; the flume is 5 m long.

TEXT
  for h in 0.1 0.2 0.3 0.4 0.5 0.6; do
    if [ $h = 0.6 ]; then
      told "H/d = $h: height / H" paddle_$h gauge4_height_over_h 'the wave asked for, which loses height at once'
    else
      near "H/d = $h: height / H" paddle_$h gauge4_height_over_h 1 3 'the wave asked for'
    fi
    near "H/d = $h: celerity / exact" paddle_$h celerity_over_theory 1 1.5 'exact'
  done
  table
  cat <<TEXT
## Loss of height

By resolution, density diffusion, viscosity and kernel: [wave_loss.md](wave_loss.md).

## Inclined wall

Huang et al. (2019), section 4.3: a wall of 120 degrees in the water; P0 and P1 on it at 0.2 and 0.6 d above the bed, force along its normal over the static one.

TEXT
  for h in 0.3 0.6; do
    file=computed_solitary_inclined_wall_a120_H$h.csv bar=$([ $h = 0.3 ] && echo 5 || echo 10)
    near "H/d = $h: P0, largest" inclined_$h p0_max_over_rho_g_d "$(exact $file 5)" $bar "exact: $(exact $file 5)"
    near "H/d = $h: P1, largest" inclined_$h p1_max_over_rho_g_d "$(exact $file 6)" $bar "exact: $(exact $file 6)"
    near "H/d = $h: force, largest" inclined_$h force_max_over_static "$(exact $file 4)" $bar "exact: $(exact $file 4)"
    if [ $h = 0.3 ]; then
      near "H/d = $h: R/d" inclined_$h run_up_over_d "$(exact $file 3)" 5 "exact: $(exact $file 3)"
    else
      told "H/d = $h: R/d" inclined_$h run_up_over_d "exact: $(exact $file 3)"
    fi
    row "H/d = $h: particles that left the flume" "$(figure "$out/inclined_$h.json" particles_lost)" 0 0 'none'
  done
  table
  cat <<TEXT
![pressures on the inclined wall](images/waves_inclined.png)

Interpolators, H/d = 0.6; what they cost is in [which_interpolator.md](which_interpolator.md#cost).
Times are from the largest force [s]; pressure and force hardly change around their peaks, so that times scatter by 0.05 s.
Huang et al. show these pressures as curves and print no figure of them.

| interpolator | P0 | when | P1 | when | force | R/d |
|---|---|---|---|---|---|---|
TEXT
  file=$measured/computed_solitary_inclined_wall_a120_H0.6.csv
  cells exact "$(series "$file" 5 most)" "$(series "$file" 5 most_at -v time=2)" "$(series "$file" 6 most)" \
    "$(series "$file" 6 most_at -v time=2)" "$(series "$file" 4 most)" "$(series "$file" 3 most)"
  for m in $methods; do
    name=$out/inclined_0.6$([ $m = improved-shepard ] || echo _$m).json
    set --
    for key in p0_max_over_rho_g_d p0_max_after_force_s p1_max_over_rho_g_d p1_max_after_force_s force_max_over_static run_up_over_d; do
      set -- "$@" "$(figure "$name" $key)"
    done
    cells "\`$m\`" "$@"
  done
  cat <<TEXT

![pressures on the inclined wall by interpolator](images/waves_interpolators.png)

Sound rings on at the wall, most with \`mls-quadratic\` and \`sfdi\`, and takes single peaks with it.

## Seawall on a spring

The tank of Liang et al. (2017) and Huang et al. (2019), section 4.4: d = 0.2 m, 2.5 m long, dx = $(figure "$out/wall_0.5_250_10.json" dx_m) m, the piston moves as in the exact computation.
Only what the force has above 1.1 times the static one pushes the wall.

TEXT
  for h in 0.3 0.5; do
    file=${tank}${h}_fixed.csv
    near "H/d = $h, fixed: largest force / static" fixed_$h force_max_over_static "$(exact $file 8)" 5 "exact: $(exact $file 8)"
    r=$(scaled 5 "$(exact $file 7)")
    near "H/d = $h, fixed: R/d" fixed_$h run_up_over_d "$r" 5 "exact: $r"
  done
  for case in 0.5_250_10 0.5_50_500 0.3_50_100; do
    h=${case%%_*} rest=${case#*_}
    m=${rest%_*} k=${rest#*_}
    file=${tank}${h}_m${m}_k$k.csv name="H/d = $h, m = $m, k = $k"
    near "$name: largest force / static" wall_$case force_max_over_static "$(exact $file 8)" 5 "exact: $(exact $file 8)"
    r=$(scaled 5 "$(exact $file 7)")
    near "$name: R/d" wall_$case run_up_over_d "$r" 5 "exact: $r"
    near "$name: largest displacement / d" wall_$case displacement_max_over_d "$(displacement $file most)" 6 "exact: $(scaled 1 "$(displacement $file most)")"
    row "$name: particles that left the tank" "$(figure "$out/wall_$case.json" particles_lost)" 0 0 'none'
  done
  near 'H/d = 0.5, m = 250, k = 10: displacement at 4 s / d' wall_0.5_250_10 displacement_end_over_d \
    "$(displacement ${tank}0.5_m250_k10.csv last)" 6 "exact: $(scaled 1 "$(displacement ${tank}0.5_m250_k10.csv last)")"
  table
  cat <<TEXT
![seawall: force, run-up and displacement](images/waves_seawall.png)

Beside the figures that the two papers print, times in s.
m = 500 is a wall twice as heavy; "as printed" is the rule of the papers' equation and its steps.
Forces are over the static one, F_thr is 1.1 of that; lengths over d.

TEXT
  printed
  cat <<TEXT

The papers' wall moves about half as far as its own equation makes it: it behaves as one about twice as heavy.
TEXT
  cat <<TEXT

## Regular and irregular waves

A flume of d = 0.25 m, kd = 1.5, H/d = 0.15, 3 wavelengths long; the last of them is a damping zone with a rate of 10 over the period, before the end wall (\`examples/regular_waves\`).
Figures are of 3 periods (irregular: 16) after energy has been to the end wall and back, at 8 gauges 1 1/8 to 2 wavelengths from the paddle.
Least squares over the gauges give the incident and the reflected first harmonic and the wave number that suits them best; height is twice the amplitude of the incident one.
To third order waves of this height are 1.2 % longer than linear ones.
The bar of the height is for 10 particles a height and more.

TEXT
  for case in fine:stokes2:piston stokes2:stokes2:piston airy:airy:piston flap:airy:flap; do
    run=regular_${case%%:*} name=${case#*:}
    name="$(awk -v dx="$(figure "$out/$run.json" dx_m)" 'BEGIN { printf "H/dx = %.1f", 0.0375 / dx }'), ${name#*:}, ${name%:*}"
    if [ "$run" = regular_fine ]; then
      near "$name: height / H" $run height_over_h 1 5 'the wave asked for'
    else
      told "$name: height / H" $run height_over_h 'the wave asked for'
    fi
    near "$name: wavelength / linear" $run wavelength_over_theory 1 2 'dispersion relation'
    row "$name: reflected / incident" "$(figure "$out/$run.json" reflection)" 0 0.1 'damping zone'
    told "$name: bound second harmonic / Stokes" $run bound_second_over_stokes 1
    told "$name: free second harmonic / Stokes" $run free_second_over_stokes 'none by second order'
  done
  told 'H/dx = 6.0, piston, stokes2, no damping zone: reflected / incident' regular_open reflection 'end wall'
  told 'H/dx = 6.0, piston, jonswap: significant height / that of linear theory' regular_jonswap height_over_h 'the same components'
  told 'H/dx = 6.0, piston, jonswap: rms of the difference / rms of linear theory' regular_jonswap apart_over_rms 'the same components'
  for run in regular_fine regular_stokes2 regular_airy regular_flap regular_open regular_jonswap; do
    row "$run: particles that left the flume" "$(figure "$out/$run.json" particles_lost)" 0 0 none
  done
  table
  cat <<TEXT
![regular and irregular waves](images/waves_regular.png)
TEXT
} >"$out/$page"
finish
