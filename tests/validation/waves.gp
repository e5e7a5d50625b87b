# Solitary waves at walls beside exact solutions.
#
#   gnuplot -e "out='folder of runs'; measured='tests/data'; images='folder'" waves.gp
set datafile separator ','
set terminal pngcairo size 1000,420 font 'DejaVu Sans,11' noenhanced
set border 3 lw 1.2
set tics nomirror out
set grid lc rgb '#dddddd' lt 1
g = 9.81
rho = 1000.0
d = 0.25
second = sqrt(d / g)
exact_history(h) = sprintf('%s/computed_solitary_wall_history_H%s.csv', measured, h)
vertical(h, file) = sprintf('%s/vertical_%s/%s.csv', out, h, file)

# Times of the exact histories are from the largest run-up: lag after the undisturbed crest.
celerity(h) = sqrt(g * d) * (h eq '0.2' ? 1.09434450 : 1.17807516)
run_up_time(h) = 20 * d / celerity(h) + (h eq '0.2' ? 0.221 : 0.400) * second

set output images.'/waves_force.png'
set multiplot layout 1,2
set xlabel 't sqrt(g/d), from the exact run-up'
set xrange [-9:6]
set ylabel 'force / static force'
set key top left
do for [h in '0.2 0.4'] {
  set title 'Vertical wall, H/d = '.h
  plot vertical(h, 'force') using (($1-run_up_time(h))/second):($2/(0.5*rho*g*d*d)) with lines lc rgb '#3182bd' title 'computed', \
       exact_history(h) using 1:3 with lines lw 2 dt 2 lc rgb 'black' title 'exact'
}
unset multiplot

set output images.'/waves_run_up.png'
set multiplot layout 1,2
set ylabel 'elevation at the wall / d'
do for [h in '0.2 0.4'] {
  set title 'Vertical wall, H/d = '.h
  plot vertical(h, 'run_up') using (($1-run_up_time(h))/second):($2/d-1) with lines lc rgb '#3182bd' title 'computed', \
       exact_history(h) using 1:2 with lines lw 2 dt 2 lc rgb 'black' title 'exact'
}
unset multiplot

# Times of the exact pressures are from the largest force: put where both have p = 1.0 at P0 first.
first_above(file, column, scale, level) = real(system(sprintf("awk -F, '/^[-0-9]/ && $%d / %g >= %g { print $1; exit }' %s", column, scale, level, file)))
set output images.'/waves_inclined.png'
set multiplot layout 1,2
set xlabel 't sqrt(g/d), from the largest exact force'
set ylabel 'p / (rho g d)'
do for [h in '0.3 0.6'] {
  exact = sprintf('%s/computed_solitary_inclined_wall_a120_H%s.csv', measured, h)
  run = sprintf('%s/inclined_%s', out, h)
  shift = first_above(run.'/p0.csv', 2, rho * g * d, 1.0) / second - first_above(exact, 5, 1, 1.0)
  set xrange [-8:6]
  set title 'Wall of 120 degrees, H/d = '.h
  plot run.'/p0.csv' using ($1/second-shift):($2/(rho*g*d)) with lines lc rgb '#3182bd' title 'P0', \
       run.'/p1.csv' using ($1/second-shift):($2/(rho*g*d)) with lines lc rgb '#e6550d' title 'P1', \
       exact using 1:5 with lines lw 2 dt 2 lc rgb 'black' title 'exact', exact using 1:6 with lines lw 2 dt 2 lc rgb 'black' notitle
}
unset multiplot

# The same wall and wave for four interpolators.
set key bottom center
set output images.'/waves_interpolators.png'
set multiplot layout 1,2
exact = measured.'/computed_solitary_inclined_wall_a120_H0.6.csv'
methods = 'improved-shepard mls-linear mls-quadratic sfdi'
run(m) = sprintf('%s/inclined_0.6%s', out, m eq 'improved-shepard' ? '' : '_'.m)
array colours[4] = ['#3182bd', '#e6550d', '#31a354', '#756bb1']
do for [gauge in 'p0 p1'] {
  column = gauge eq 'p0' ? 5 : 6
  set title sprintf('Wall of 120 degrees, H/d = 0.6: %s', gauge eq 'p0' ? 'P0' : 'P1')
  plot for [k=1:4] run(word(methods, k)).'/'.gauge.'.csv' \
         using ($1/second-first_above(run(word(methods, k)).'/p0.csv', 2, rho * g * d, 1.0)/second+first_above(exact, 5, 1, 1.0)):($2/(rho*g*d)) \
         with lines lc rgb colours[k] title word(methods, k), \
       exact using 1:column with lines lw 2 dt 2 lc rgb 'black' title 'exact'
}
unset multiplot
set key top left

d = 0.2
still = 0.5 * rho * g * d * d
set output images.'/waves_seawall.png'
set terminal pngcairo size 1000,640 font 'DejaVu Sans,11' noenhanced
set multiplot layout 2,2
set xlabel 't [s]'
set xrange [0:4]
run = out.'/wall_0.5_250_10'
exact = measured.'/computed_liang_tank_H0.5_m250_k10.csv'
set title 'H/d = 0.5, m = 250 kg/m, k = 10 N/m'
set ylabel 'force / static force'
plot run.'/force.csv' using 1:($2/still) with lines lc rgb '#3182bd' title 'computed', exact using 1:8 with lines lw 2 dt 2 lc rgb 'black' title 'exact'
set ylabel 'elevation at the wall / d'
plot run.'/run_up.csv' using 1:($2/d-1) with lines lc rgb '#3182bd' title 'computed', exact using 1:($7/d) with lines lw 2 dt 2 lc rgb 'black' title 'exact'
set ylabel 'displacement / d'
plot run.'/wall.csv' using 1:($2/d) with lines lc rgb '#3182bd' title 'computed', exact using 1:(($4-2.5)/d) with lines lw 2 dt 2 lc rgb 'black' title 'exact', \
     out.'/wall_0.5_500_10/wall.csv' using 1:($2/d) with lines lc rgb '#e6550d' title 'computed, m = 500'
run = out.'/wall_0.5_50_500'
exact = measured.'/computed_liang_tank_H0.5_m50_k500.csv'
set title 'H/d = 0.5, m = 50 kg/m, k = 500 N/m'
plot run.'/wall.csv' using 1:($2/d) with lines lc rgb '#3182bd' title 'computed', exact using 1:(($4-2.5)/d) with lines lw 2 dt 2 lc rgb 'black' title 'exact'
unset multiplot

# Waves of a paddle at the gauge 1 1/2 wavelengths from it.
d = 0.25
second = sqrt(d / g)
set output images.'/waves_regular.png'
set multiplot layout 2,1
set xlabel 't sqrt(g/d)'
set ylabel 'elevation / d'
set key top right horizontal
do for [case in 'fine jonswap'] {
  set title case eq 'fine' ? 'Piston, second order, H/d = 0.15, kd = 1.5' : 'Piston, JONSWAP, Hs/d = 0.15, kd of the peak 1.5'
  run = sprintf('%s/regular_%s', out, case)
  set xrange [case eq 'fine' ? 0 : 55:case eq 'fine' ? 65 : 120]
  set yrange [-0.15:0.2]
  plot run.'/gauge3.csv' using ($1/second):($2/d-1) with lines lc rgb '#3182bd' title 'computed', \
       run.'/theory.csv' using ($1/second):($5/d) with lines lw 2 dt 2 lc rgb 'black' title case eq 'fine' ? 'Stokes, endless' : 'linear'
}
unset multiplot
