#!/bin/sh
# What a solitary wave of H/d = 0.5 loses on its way, and how its pressure scatters, by resolution, density
# diffusion, viscosity and kernel. Writes FOLDER/wave_loss.md.
#
#   wave_loss.sh FOLDER [--quick] [--report] [--update]
#
# --quick    coarse, to try the script itself; the figures mean nothing
# --report   write the page from the runs that are in FOLDER already
# --update   copy the page to docs/
# BUILD in the environment is where the examples were built.
set -eu
page=wave_loss.md wants=solitary_wave
# shellcheck source=tests/validation/runs.sh
. "$(dirname "$0")/runs.sh"

# d = 0.25 m. The crest starts 6 d from the left side and 1 d before the first of four gauges, 3 d apart;
# the run ends 2 sqrt(d/g) after it has passed the last, 9 d before the other side.
flume='--height-ratio 0.5 --length 6.25 --crest 4.75 --end 1.75 --threads 1'
diffusions='none molteni delta'
viscosities='water 0 0.005 0.01 0.02 0.05' # alpha, or the laminar viscosity of water alone
[ "$quick" = 1 ] && levels='5 5 5' || levels='10 20 40'
# shellcheck disable=SC2086  # words
set -- $levels
coarse=$1 middle=$2 fine=$3
fine_cases='delta_0 delta_0.01 delta_0.02 none_0.02'
kernels='wendland-c2_2 wendland-c2_1.5 wendland-c4_2 wendland-c6_2 gaussian_1.3' # name_h/dx, the default first
walls='wendland-c2_2 gaussian_1.3' heights='0.3 0.4 0.5 0.6'
default=delta_0.01

spacing() { awk -v n="$1" 'BEGIN { print 0.125 / n }'; }
terms() {
  case $1 in
    water) echo '--alpha 0 --viscosity 1e-6' ;;
    *) echo "--alpha $1" ;;
  esac
}
# case_of LEVEL DIFFUSION VISCOSITY [OPTION ...]
case_of() {
  level=$1 diffusion=$2 viscosity=$3
  shift 3
  # shellcheck disable=SC2046,SC2086  # lists of words
  run "${level}_${diffusion}_$viscosity" solitary_wave $flume --dx "$(spacing "$level")" --diffusion "$diffusion" $(terms "$viscosity") "$@"
}
for level in $coarse $middle; do
  for diffusion in $diffusions; do
    for viscosity in $viscosities; do case_of "$level" "$diffusion" "$viscosity"; done
  done
done
for stepper in symplectic verlet; do
  # shellcheck disable=SC2086
  run stepper_$stepper solitary_wave $flume --dx "$(spacing "$middle")" --stepper $stepper
done
for level in $coarse $middle; do
  for kernel in $kernels; do
    set -- --dx "$(spacing "$level")" --kernel "${kernel%_*}" --h "${kernel#*_}"
    # shellcheck disable=SC2086
    [ "$kernel" = wendland-c2_2 ] || run "kernel_${level}_$kernel" solitary_wave $flume "$@"
  done
done
for kernel in $walls; do
  for h in $heights; do
    set -- --kernel "${kernel%_*}" --h "${kernel#*_}"
    [ "$quick" = 1 ] && set -- "$@" --dx 0.025
    run "wall_${kernel}_$h" solitary_wave --height-ratio "$h" --length 4.75 --threads 1 "$@"
  done
done
for case in $fine_cases; do case_of "$fine" "${case%_*}" "${case#*_}"; done

# Heights of the gauges 0 to 9 d by a straight line, energy over that of the exact wave, in per cent.
energy=$(awk -F, '$1 == 0.5 { print $9 * 9810 * 0.25 ^ 3 }' "$measured/solitary_exact_integral_properties.csv")
volume=$(awk -F, '$1 == 0.5 { print $5 }' "$measured/solitary_exact_integral_properties.csv")
length=$(awk -F, -v all="$volume" '/^[0-9]/ {
    sum += n++ ? ($1 - x) * ($7 + eta) : 0
    x = $1
    eta = $7
    if (sum >= 0.95 * all) { printf "%.2f\n", 2 * x; exit } }' "$measured/solitary_exact_profiles.csv")
# losses RUN: height and energy lost in 9 d, celerity / exact, bed noise, scatter
losses() {
  file=$out/$1.json
  [ -f "$file" ] || { echo 'none | | | | |'; return 0; }
  set --
  for key in gauge0_height_over_h gauge1_height_over_h gauge2_height_over_h gauge3_height_over_h energy_lost_gauge0_to_3_j \
    celerity_over_theory bed_noise_over_rho_g_d pressure_roughness_over_rho_g_d; do set -- "$@" "$(figure "$file" $key)"; done
  echo "$@" | awk -v e="$energy" '/null/ { print "did not run | | | |"; exit }
    { down = (3 * ($1 - $4) + $2 - $3) / 10 # between two gauges
      first = ($1 + $2 + $3 + $4) / 4 + 1.5 * down
      printf "%.1f %% | %.1f %% | %.3f | %.4f | %.5f |\n", 300 * down / first, 100 * $5 / e, $6, $7, $8 }'
}
# of RUN NUMBER: one of them.
of() { losses "$1" | cut -d'|' -f"$2" | tr -d ' ' | sed 's/%/ %/'; }
head='height per 9 d | energy per 9 d | celerity / exact | noise at the bed | scatter of particles |'
cases() {
  echo "| H/dx | diffusion | viscosity | $head"
  echo '|---|---|---|---|---|---|---|---|'
  for case in "$@"; do
    name=${case#*_}
    viscosity=${name#*_}
    case $viscosity in
      water) viscosity='1e-6 m²/s, alpha = 0' ;;
      *) viscosity="alpha = $viscosity" ;;
    esac
    printf '| %s | %s | %s | %s\n' "${case%%_*}" "${name%_*}" "$viscosity" "$(losses "$case")"
  done
  echo
}
{
  cat <<TEXT
# What waves lose

This page is written by \`make wave-loss\` and \`tests/validation/wave_loss.sh build/wave_loss --report --update\`: every figure comes out of its runs.

A solitary wave of H/d = 0.5 that is there at t = 0, as the exact theory has it, runs along a flume (\`examples/solitary_wave\`, d = 0.25 m, c0 = 10 sqrt(g (d + H)), Wendland C2 kernel with h = 2 dx unless said otherwise).
Four gauges stand 3 d apart, the first 1 d before its crest.
Its effective length, which holds 95 % of its volume, is $length d: 9 d are $(awk -v l="$length" 'BEGIN { printf "%.2f", 9 / l }') of it.

- *Height*: of the crest, by a straight line through the gauges, in per cent for each 9 d.
- *Energy*: total energy of the flume between the crest's passing the first and the last gauge, in per cent of the exact wave's.
- *Celerity*: from the second to the last gauge, by the front at H/2.
- *Noise at the bed*: of the pressure below the last gauge for 2 sqrt(d/g) before and after the crest, rms of what twice a mean over 0.5 sqrt(d/g) takes away, / (rho g d). Sound that goes up and down since the start is part of it.
- *Scatter*: of the single particles' pressures where the wave has been, rms of what a parabola fitted through the neighbours leaves, / (rho g d). Gauges and forces are means over neighbours and hide it; it is what pictures show and what ghosts get.

## Diffusion and viscosity

TEXT
  for level in $coarse $middle; do
    set --
    for diffusion in $diffusions; do
      for viscosity in $viscosities; do set -- "$@" "${level}_${diffusion}_$viscosity"; done
    done
    cases "$@"
  done
  set --
  for case in $fine_cases; do set -- "$@" "${fine}_$case"; done
  cases "$@"
  cat <<TEXT
- **The flumes of the examples take \`delta\` and alpha = 0.01.** A wave then loses $(of "${coarse}_$default" 1), $(of "${middle}_$default" 1) and $(of "${fine}_$default" 1) of its height in 9 d with $coarse, $middle and $fine particles a height, and $(of "${coarse}_$default" 2), $(of "${middle}_$default" 2) and $(of "${fine}_$default" 2) of its energy. The library's alpha = 0.02, which Huang et al. (2019) take, loses more and is hardly quieter.
- Less viscosity loses less and is not quiet: at H/dx = $middle particles scatter by $(of "${middle}_delta_0" 5) rho g d without any, $(of "${middle}_delta_0.005" 5) with alpha = 0.005 and $(of "${middle}_$default" 5) with 0.01; the noise at the bed is $(of "${middle}_delta_0" 4), $(of "${middle}_delta_0.005" 4) and $(of "${middle}_$default" 4).
- Much of the loss is not viscosity's: without any it is $(of "${coarse}_delta_0" 1) at H/dx = $coarse and $(of "${middle}_delta_0" 1) at $middle. Water's own 1e-6 m²/s does nothing at these spacings.
- Without density diffusion and viscosity energy is kept ($(of "${middle}_none_0" 2) lost) and pressure is not: particles scatter by $(of "${middle}_none_0" 5) rho g d, with alpha = 0.01 still by $(of "${middle}_none_0.01" 5), and then nothing is won.
- \`molteni\` is as quiet as \`delta\` and diffuses the hydrostatic gradient too: the water at rest sinks, and the flume loses $(of "${coarse}_molteni_0.01" 2) and $(of "${middle}_molteni_0.01" 2) of the wave's energy. Not for flumes.

TEXT
  cat <<TEXT
## Kernel

Terms of the flumes.

| H/dx | kernel | $head
|---|---|---|---|---|---|---|
TEXT
  for level in $coarse $middle; do
    for kernel in $kernels; do
      name=kernel_${level}_$kernel
      [ "$kernel" = wendland-c2_2 ] && name=${level}_$default
      printf '| %s | `%s`, h = %s dx | %s\n' "$level" "${kernel%_*}" "${kernel#*_}" "$(losses "$name")"
    done
  done
  cat <<TEXT

Waves at a vertical wall, 19 d from the other side, d/dx = 25: run-up R/d and largest force over the static one.

| H/d | exact: R/d | force | \`wendland-c2\`, h = 2 dx: R/d | force | \`gaussian\`, h = 1.3 dx: R/d | force |
|---|---|---|---|---|---|---|
TEXT
  for h in $heights; do
    printf '| %s | %s' "$h" "$(awk -F, -v h="$h" '/^[0-9]/ && $1 + 0 == h { printf "%.3f | %.3f |", $2, $5 }' "$measured/computed_solitary_wall_runup_force_summary.csv")"
    for kernel in $walls; do
      for key in run_up_over_d force_max_over_static; do
        awk -v x="$(figure "$out/wall_${kernel}_$h.json" $key)" 'BEGIN { printf " %.3f |", x }'
      done
    done
    echo
  done
  cat <<TEXT

The default is nearer to the exact forces and keeps the jet of a steep run-up together longer; where that jet is thinner than a few particles, from H/d = 0.5 on, R/d scatters by 0.1 from flume to flume.
With $middle particles a height the Gaussian loses less on the way, for waves that do not run up steeply: \`--kernel gaussian --h 1.3\`. With $coarse it loses as much energy, and its waves are too fast.

## Stepper

H/dx = $middle, terms of the flumes.

| stepper | $head
|---|---|---|---|---|---|
| \`rk4\` | $(losses "${middle}_$default")
| \`symplectic\` | $(losses stepper_symplectic)
| \`verlet\` | $(losses stepper_verlet)

The loss is none of time stepping.
TEXT
} >"$out/$page"
finish
