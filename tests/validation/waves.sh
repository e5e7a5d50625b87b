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
coarse='' coarse_tank=''
[ "$quick" = 1 ] && coarse='--dx 0.025 --length 6' coarse_tank='--dx 0.025'
tank="computed_liang_tank_H"

# Small runs are faster side by side than on two threads.
one() { run "$@" --threads 1; }
# shellcheck disable=SC2086  # lists of words
{
  for h in $ratios; do one vertical_$h solitary_wave --height-ratio $h $coarse; done
  for h in 0.3 0.6; do one inclined_$h solitary_wave --wall inclined --height-ratio $h $coarse; done
  for dx in 0.00625 0.0125 0.025; do
    one loss_$dx solitary_wave --height-ratio 0.3 --dx $([ "$quick" = 1 ] && echo 0.025 || echo $dx)
  done
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
# exact FILE COLUMN: the largest value. summary H COLUMN: of the table of vertical walls.
exact() { awk -F, -v c="$2" '/^[-0-9]/ && (n++ == 0 || $c + 0 > most) { most = $c + 0 } END { print most }' "$measured/$1"; }
summary() { awk -F, -v h="$1" -v c="$2" '/^[0-9]/ && $1 + 0 == h { print $c }' "$measured/computed_solitary_wall_runup_force_summary.csv"; }
# displacement FILE WHAT: of the wall from 2.5 m, in depths of 0.2 m, largest or last.
displacement() {
  awk -F, -v what="$2" '/^[0-9]/ { x = ($4 - 2.5) / 0.2; if (x > most) most = x; last = x }
    END { print what == "last" ? last : most }' "$measured/$1"
}
{
  cat <<TEXT
# Validation: waves and seawalls

This page is written by \`make validate-waves\` and \`tests/validation/waves.sh build/waves --report --update\`: every figure comes out of the runs below, with the bar that it has to stay in.
A figure outside its bar says **no**; nothing is left out.
What the figures mean is in [examples.md](examples.md).

Exact means potential flow without approximation, computed by boundary elements and conformal maps (files \`computed_*\` in \`tests/data\`).
δ-SPH with fixed ghosts by improved Shepard, Wendland C2 kernel with h = 2 dx, c0 = 10 sqrt(g (d + H)), alpha = 0.02, 25 particles a depth unless said otherwise.
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

The wave of H/d = 0.3 between gauges 18 and 9 d before the wall, in per cent of its height for each 9 d, by particles a height H.

| H/dx | dx [m] | lost |
|---|---|---|
TEXT
  for dx in 0.00625 0.0125 0.025; do
    awk -v dx="$(figure "$out/loss_$dx.json" dx_m)" -v a="$(figure "$out/loss_$dx.json" gauge0_height_over_h)" \
      -v b="$(figure "$out/loss_$dx.json" gauge3_height_over_h)" 'BEGIN { printf "| %g | %g | %.1f %% |\n", 0.075 / dx, dx, 100 * (1 - b / a) }'
  done
  cat <<TEXT

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

Interpolators, H/d = 0.6, what they cost is in [which_interpolator.md](which_interpolator.md#cost):

| interpolator | P0 | P1 | force | R/d |
|---|---|---|---|---|
TEXT
  for m in $methods; do
    name=inclined_0.6$([ $m = improved-shepard ] || echo _$m)
    awk -v m=$m -v p0="$(figure "$out/$name.json" p0_max_over_rho_g_d)" -v p1="$(figure "$out/$name.json" p1_max_over_rho_g_d)" \
      -v f="$(figure "$out/$name.json" force_max_over_static)" -v r="$(figure "$out/$name.json" run_up_over_d)" \
      'BEGIN { printf "| `%s` | %.3f | %.3f | %.3f | %.3f |\n", m, p0, p1, f, r }'
  done
  cat <<TEXT

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

Beside the figures that the two papers print for H/d = 0.5, m = 250 kg/m, k = 10 N/m, and a wall twice as heavy:

| | force / static | R/d | displacement at 4 s / d |
|---|---|---|---|
| Liang et al. (2017) | 2.73 | 1.04 | 2.16 |
| Huang et al. (2019) | | | 2.3 |
| exact, m = 250 | $(exact ${tank}0.5_m250_k10.csv 8) | $(scaled 5 "$(exact ${tank}0.5_m250_k10.csv 7)") | $(scaled 1 "$(displacement ${tank}0.5_m250_k10.csv last)") |
TEXT
  for case in 0.5_250_10 printed 0.5_500_10; do
    case $case in
      0.5_250_10) name='here, m = 250' ;;
      printed) name='here, m = 250, the rule as printed' ;;
      *) name='here, m = 500' ;;
    esac
    echo "| $name | $(scaled 1 "$(figure "$out/wall_$case.json" force_max_over_static)") | $(scaled 1 "$(figure "$out/wall_$case.json" run_up_over_d)") | $(scaled 1 "$(figure "$out/wall_$case.json" displacement_end_over_d)") |"
  done
  cat <<TEXT

The papers' wall moves about half as far as its own equation makes it: it behaves as one about twice as heavy.
TEXT
} >"$out/$page"
finish
