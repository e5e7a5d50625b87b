#!/bin/sh
# The published cases in full: the hydrostatic tanks, the dam break with its fronts, the dam break in 3D.
# Writes FOLDER/validation.md with figures, bars and plots.
#
#   run.sh FOLDER [--quick] [--report] [--update]
#
# --quick    coarse and short, to try the script itself; the figures mean nothing
# --report   write the page from the runs that are in FOLDER already
# --update   copy the page to docs/validation.md and its plots to docs/images/
# BUILD in the environment is where the examples were built.
set -eu
page=validation.md wants=dam_break
# shellcheck source=tests/validation/runs.sh
. "$(dirname "$0")/runs.sh"

rest=35 flat='' small='--dx 0.00146' deep=''
if [ "$quick" = 1 ]; then rest=1 flat='--dx 0.02' small='--dx 0.00584' deep='--dx 0.0625 --end-t-star 2'; fi
# Small runs are faster side by side than on two threads.
{
  run rest_box_shepard hydrostatic --end $rest --threads 1
  run rest_inclined hydrostatic --end $rest --threads 1 --tank inclined
} &
{
  run rest_box_mls hydrostatic --end $rest --threads 1 --interpolator mls-linear
  run rest_step hydrostatic --end $rest --threads 1 --tank step
}
wait
# shellcheck disable=SC2086  # lists of words
{
  run front dam_break --height 0.292 --length 0.146 --tank 0.73 --end-t-star 1.8 $small
  run dam_break dam_break --pictures 11 $flat
  run dam_break_3d dam_break --dim 3 --end-t-star 5 --pictures 8 $deep
}

mkdir -p "$out/images"
rm -f "$out"/images/*.png
plot -e "run='$out/dam_break'; small='$out/front'; measured='$measured'; images='$out/images'" "$examples/dam_break_plots.gp"
pictures() {
  frames=$(find "$out/$1" -name 'picture_*.txt' | wc -l | tr -d ' ')
  mkdir -p "$out/frames"
  plot -e "run='$out/$1'; images='$out/frames'; frames=$frames; tank=$2; top=$3; width=760" "$examples/dam_break_pictures.gp"
  mv "$out/frames/flow.png" "$out/images/$1_flow.png"
  rm -r "$out/frames"
}
pictures dam_break 5.366 2
pictures dam_break_3d 4 2
for tank in box_shepard box_mls inclined step; do
  plot -e "run='$out/rest_$tank'; images='$out/images'; name='$tank'" "$examples/hydrostatic_plots.gp"
done

speed() { echo "$(figure "$out/$1.json" particles) particles, $(figure "$out/$1.json" steps) steps, $(figure "$out/$1.json" wall_seconds) s on $(figure "$out/$1.json" threads) threads ($(figure "$out/$1.json" isa))"; }
rest_rows() {
  file=$out/$1.json
  for k in 0 1 2 3; do
    row "P$k, largest error / (rho g H)" "$(figure "$file" p${k}_error_max_rel)" 0 0.01 'rho g (H - y)'
  done
  row 'P0, drift of the mean, last fifth - first fifth' "$(figure "$file" p0_drift_rel)" -0.002 0.002 'none'
  row 'rms velocity / sqrt(g H) at the end' "$(figure "$file" velocity_rms_over_sqrt_gh)" 0 0.002 'at rest'
  row 'kinetic energy, last fifth / first fifth' "$(awk -v a="$(figure "$file" kinetic_energy_mean_last_fifth_j)" \
    -v b="$(figure "$file" kinetic_energy_mean_first_fifth_j)" 'BEGIN { if (b > 0) print a / b; else print "null" }')" 0 1 'falling'
  row 'particles that left the tank' "$(figure "$file" particles_lost)" 0 0 'none'
}
{
  cat <<'TEXT'
# Validation

This page is written by `make validate` and `tests/validation/run.sh build/validation --report --update`: every
figure comes out of the runs below, with the bar that it has to stay in.
A figure outside its bar says **no**; nothing is left out.
What the figures mean is in [examples.md](examples.md).

## Water at rest

Huang et al. (2019), section 4.1: 0.3 m of water in a tank of 1 m, dx = 0.01 m, Gaussian kernel with h = 1.3 dx, c0 = 10 sqrt(g H), started from the exact pressure.
The time step follows the stability limits.
Errors are the largest of the whole run, relative to rho g H, of the pressure on the left wall against rho g (H - y); at P0 the compressibility of the fluid alone is worth 0.005.

TEXT
  for tank in box_shepard box_mls inclined step; do
    case $tank in
      box_shepard) echo '### Box, improved Shepard' ;;
      box_mls) echo '### Box, linear moving least squares' ;;
      inclined) echo '### Right wall leaning outward, 120 degrees inside, improved Shepard' ;;
      step) echo '### Bed raised by 0.1 m from x = 0.5 m on, improved Shepard' ;;
    esac
    printf '\n%s.\n\n' "$(speed rest_$tank)"
    rest_rows rest_$tank
    table
    echo "![pressure](images/hydrostatic_${tank}_pressure.png)"
    printf '![kinetic energy](images/hydrostatic_%s_kinetic.png)\n\n' "$tank"
  done
  cat <<TEXT
## Dam break

Huang et al. (2019), section 4.2: a column of 1.2 x 0.6 m in a tank of 3.22 m, dx = $(figure "$out/dam_break.json" dx_m) m, Gaussian kernel with h = 1.3 dx, c0 = 20 sqrt(g H), improved Shepard, started from the pressure of Laplace's equation.
$(speed dam_break).

TEXT
  dam_break_rows "$out/dam_break.json" "$out/dam_break" "$out/front"
  table
  cat <<'TEXT'
![flow](images/dam_break_flow.png)
![wall pressure](images/p1_pressure.png)
![front](images/front.png)
![energy](images/energy.png)

Remarks:

- Buchner's gauge is a plate 90 mm across, centred 0.16 m above the bed; its mean is weighted with the chords. P1 is its lower edge, 0.115 m = 0.19 H, where published computations are compared with it; Huang et al. do not print the height of their P1. Peaks are those of the mean over 0.1 sqrt(H/g); the plot has the signal of every step as well. The experiment is a single run with 90 points read from a figure.
- The gate of the experiments takes time to go up, that of the computation none: no time is shifted here. For the column of the experiments on fronts (L wide, 2 L high) the computed front is ahead by a nearly constant time, as a late gate makes it; the bar asks for this sign, and for a small spread.
- The long column (L wide, L/2 high) is no similar copy of those experiments. x/L against t sqrt(2 g/L) is the way this case is commonly shown.
- The bed is smooth and the water has no surface tension.
- The air in the closing cavity is missing: after the closure near 5.98 the computation is that of water with an empty cavity.

TEXT
  cat <<TEXT
## Dam break in three dimensions

A column of 1.0 x 0.5 x 0.5 m in a closed box of 2.0 x 0.5 x 1.5 m, dx = $(figure "$out/dam_break_3d.json" dx_m) m, Wendland C2 kernel with h = 1.5 dx.
$(speed dam_break_3d).

TEXT
  row 'largest growth of the total energy / E(0)' "$(figure "$out/dam_break_3d.json" energy_growth_max_rel)" 0 0.001 'never grows'
  row 'particles that left the box' "$(figure "$out/dam_break_3d.json" particles_lost)" 0 0 'none'
  row 'the run reached its end, t sqrt(g/H)' "$(awk -v t="$(figure "$out/dam_break_3d.json" time_end_s)" \
    'BEGIN { print t * sqrt(9.81 / 0.5) }')" "$([ "$quick" = 1 ] && echo 1.99 || echo 4.99)" 6 'stable'
  row 'asymmetry in y until t sqrt(g/H) = 1: off the mirror image / dx' "$(figure "$out/dam_break_3d.json" asymmetry_early_max_over_dx)" 0 1e-5 'round-off of single precision sums'
  table
  echo '![flow, seen from the side](images/dam_break_3d_flow.png)'
  echo
  echo 'Round-off grows in a breaking flow as in any chaotic one: symmetry to round-off is asked for before the impact.'
} >"$out/$page"
finish
