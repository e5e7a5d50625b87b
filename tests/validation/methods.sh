#!/bin/sh
# The same flumes by three methods: particles and a mesh, incompressible and weakly compressible SPH. Writes
# FOLDER/methods_compared.md with tables and plots.
#
#   methods.sh FOLDER [--quick] [--report] [--update]
#
# --quick    coarse, to try the script itself; the figures mean nothing
# --report   write the page from the runs that are in FOLDER already
# --update   copy the page to docs/ and its plots to docs/images/
# BUILD in the environment is where the examples were built.
set -eu
page=methods_compared.md wants=wave_basin
here=$(cd "$(dirname "$0")" && pwd)
# shellcheck source=tests/validation/runs.sh
. "$here/runs.sh"
methods='flip isph wcsph'
sizes() { [ "$quick" = 0 ] || echo "--cell $1"; }

# One thread each, so that times are those of a processor.
for m in $methods; do
  # shellcheck disable=SC2046  # lists of words
  {
    run standing_$m wave_basin --method $m --threads 1 --case standing $(sizes 0.5)
    for h in 0.2 0.35; do
      run solitary_${h}_$m wave_basin --method $m --threads 1 --case solitary --height-ratio $h $(sizes 0.1)
    done
    run bar_$m wave_basin --method $m --threads 1 --case bar --pictures 14 $(sizes 0.14)
  }
done

mkdir -p "$out/images"
rm -f "$out"/images/*.png
plot -e "out='$out'; images='$out/images'" "$root/tests/validation/methods.gp"

called() {
  case $1 in
    flip) echo 'particles and a mesh' ;;
    isph) echo 'incompressible SPH' ;;
    wcsph) echo 'δ-SPH' ;;
  esac
}
# line RUN KEY ...: a row of a table, a method each.
line() {
  case_=$1
  shift
  for m in $methods; do
    printf '| %s |' "$(called "$m")"
    for key in "$@"; do
      value=$(figure "$out/${case_}_$m.json" "$key")
      awk -v x="$value" 'BEGIN { if (x == "null") printf " - |"; else printf " %.4g |", x }'
    done
    echo
  done
}
cost='particles steps processor_seconds peak_memory_mb'
of() { figure "$out/$1.json" "$2"; }

{
  cat <<TEXT
# The same flumes by three methods

Made by \`make compare-methods\`; do not edit.
\`examples/wave_basin\` computes each case with particles and a mesh (\`--method flip\`, water and air), incompressible SPH (\`isph\`) and δ-SPH (\`wcsph\`), on one thread, each with the settings it has unless told otherwise.
Triangles have a leg l and 9 particles each at the start; particles of SPH are l/2 apart.
Levels and the mode are sums over particles, in the same way for all, levels within a bell that reaches 4 l to both sides.
Time is the processor's in the library, one thread; memory the largest of the whole program.

## Standing wave

A basin of 20 m with water d = 5 m deep and a wave as long as it is, H/d = 0.1, from rest; l = $(of standing_flip cell_m) m.

| method | period / linear theory | mode after 4 periods | kinetic energy lost in 4 | pressure error, T/2 | pressure error, T | particles | steps | processor s | MB |
|---|---|---|---|---|---|---|---|---|---|
TEXT
  # shellcheck disable=SC2086
  line standing period_over_theory mode_after_4_periods energy_lost_in_4_periods pressure_error_half_period pressure_error_period $cost
  cat <<TEXT

The mode is the surface's part in cos(2 pi x/L), over that at the start.
The energy is the largest kinetic energy in the ninth half period, beside that in the first.
Pressures are those below the middle, largest difference from linear theory over rho g d; second order in H/d, about 0.005 there, is no error.
Of a wave of this height second order changes the period by +0.1 %.
Maljaars et al. (2017) lose about 40 % of the energy in four periods, and quote 69 % for SPH.

![the standing wave by three methods](images/methods_standing.png)

## Solitary waves

A flume of 15 m, d = 0.3 m, a piston after Goring with Rayleigh's wave, 8 s; l = $(of solitary_0.2_flip cell_m) m.
The crest at the end is beside Fenton's wave, which passes the middle of the stroke when the piston does.

TEXT
  for h in 0.2 0.35; do
    cat <<TEXT
H/d = $h:

| method | height / H at 3 m | 6 m | 9 m | speed / Rayleigh | crest / H at 8 s | crest behind / d | particles | steps | processor s | MB |
|---|---|---|---|---|---|---|---|---|---|---|
TEXT
    # shellcheck disable=SC2086
    line solitary_$h gauge0_over_h gauge1_over_h gauge2_over_h celerity_over_theory crest_over_h crest_behind_theory_over_d $cost
    echo
  done
  cat <<TEXT
![solitary waves at 9 m by three methods](images/methods_solitary.png)

## Breaking over a bar

A flume of 13 m, d = 0.4 m, H/d = 0.625, a bar of 0.25 m whose slopes begin at 6 m and end at 11 m; l = $(of bar_flip cell_m) m.
Maljaars et al. (2017) see the wave steepen at 4.5 s, plunge at 5 s and break at 5.5 s; their bar's measures are lost, so places and times are ours.

| method | height / H at 3 m | 5.5 m | 7.5 m | particles | steps | processor s | MB |
|---|---|---|---|---|---|---|---|
TEXT
  # shellcheck disable=SC2086
  line bar gauge0_over_h gauge1_over_h gauge2_over_h $cost
  cat <<TEXT

![the wave over the bar by three methods](images/methods_bar.png)
TEXT
} >"$out/$page"
finish
