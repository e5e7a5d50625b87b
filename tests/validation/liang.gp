# Time histories of the seawalls of Liang et al. (2017) beside exact solutions.
#
#   gnuplot -e "out='folder of runs'; measured='tests/data'; images='folder'" liang.gp
set datafile separator ','
set terminal pngcairo size 1000,560 font 'DejaVu Sans,10' noenhanced
set border 3 lw 1.2
set tics nomirror out
set grid lc rgb '#dddddd' lt 1
g = 9.81; rho = 1000.0; h = 0.2
still = 0.5 * rho * g * h * h
second = sqrt(h / g)
figure(run, key) = real(system(sprintf("sed -n 's/^ *\"%s\": *\\([-0-9.e+]*\\).*/\\1/p' '%s/%s.json'", key, out, run)))
array colours[6] = ['#9ecae1', '#4292c6', '#08519c', '#fdae6b', '#e6550d', '#a63603']

# Figure 5 of the paper: time from the largest run-up; means over 0.5 sqrt(h/g).
smooth_of(run, width) = sprintf("< awk -F, -v w=%g '/^[0-9]/ { t[n] = $1; v[n++] = $2 } END { for (k = 0; k < n; k++) { while (a < n && t[a] <= t[k] + w / 2) s += v[a++]; while (t[b] < t[k] - w / 2) s -= v[b++]; print t[k] \",\" s / (a - b) } }' '%s/%s/force.csv'", width, out, run)
set output images.'/liang_fixed.png'
set multiplot layout 2,3
set xrange [-8:4]
set xlabel '(t - t0) sqrt(g/h)'
set ylabel 'force / static force'
set key top left
do for [e in '0.1 0.2 0.3 0.4 0.5 0.6'] {
  set title 'fixed wall, H/h = '.e
  t0 = figure('fixed_'.e, 'run_up_time_s')
  plot smooth_of('fixed_'.e, 0.5 * second) using (($1-t0)/second):($2/still) with lines lw 1.5 lc rgb '#3182bd' title 'computed', \
       measured.'/computed_solitary_wall_history_H'.e.'.csv' using 1:3 with lines lw 2 dt 2 lc rgb 'black' title 'exact wave'
}
unset multiplot

# Figure 9.
set output images.'/liang_illustrated.png'
set multiplot layout 1,3 title 'H/h = 0.5, m = 250 kg/m, k = 10 N/m'
set xrange [1.5:4]
set xlabel 't [s]'
unset title
exact = measured.'/computed_liang_tank_H0.5_m250_k10.csv'
run = out.'/wall_0.5_250_10'
twice = out.'/wall_0.5_500_10'
set ylabel 'force / static force'
set key top right
plot smooth_of('fixed_0.5', 0.5 * second) using 1:($2/still) with lines lc rgb '#bbbbbb' title 'fixed wall', \
     smooth_of('wall_0.5_250_10', 0.5 * second) using 1:($2/still) with lines lc rgb '#3182bd' title 'computed', exact using 1:8 with lines lw 2 dt 2 lc rgb 'black' title 'exact'
set ylabel 'displacement / h'
set key top left
plot run.'/wall.csv' using 1:($2/h) with lines lw 1.5 lc rgb '#3182bd' title 'computed', exact using 1:(($4-2.5)/h) with lines lw 2 dt 2 lc rgb 'black' title 'exact', \
     twice.'/wall.csv' using 1:($2/h) with lines lc rgb '#e6550d' title 'computed, m = 500', '+' using (4):(2.16) with points pt 7 lc rgb '#31a354' title 'Liang et al.'
set ylabel 'level at the wall / h'
set key top right
plot out.'/fixed_0.5/run_up.csv' using 1:($2/h-1) with lines lc rgb '#bbbbbb' title 'fixed wall', \
     run.'/run_up.csv' using 1:($2/h-1) with lines lc rgb '#3182bd' title 'computed', exact using 1:($7/h) with lines lw 2 dt 2 lc rgb 'black' title 'exact'
unset multiplot

# Figures 10-12: force, displacement, run-up of a list of runs.
do for [which = 1:3] {
  runs = which == 1 ? '0.3_50_10 0.3_50_100 0.3_50_1000 0.3_50_10000' : \
         which == 2 ? '0.5_50_500 0.5_100_500 0.5_175_500 0.5_250_500 0.5_375_500 0.5_500_500' : \
                      '0.2_250_500 0.3_250_500 0.4_250_500 0.5_250_500 0.6_250_500'
  labels = which == 1 ? '10 100 1e3 1e4' : which == 2 ? '50 100 175 250 375 500' : '0.2 0.3 0.4 0.5 0.6'
  set output images.(which == 1 ? '/liang_stiffness.png' : which == 2 ? '/liang_mass.png' : '/liang_height.png')
  set multiplot layout 1,3 title (which == 1 ? 'H/h = 0.3, m = 50 kg/m' : which == 2 ? 'H/h = 0.5, k = 500 N/m' : 'm = 250 kg/m, k = 500 N/m')
  set key top right title (which == 1 ? 'k [N/m]' : which == 2 ? 'm [kg/m]' : 'H/h') samplen 2
  set ylabel 'force / static force'
  plot for [i = 1:words(runs)] smooth_of('series_'.word(runs, i), 0.5 * second) using 1:($2/still) with lines lw 1.5 lc rgb colours[i] title word(labels, i)
  unset key
  set ylabel 'displacement / h'
  plot for [i = 1:words(runs)] out.'/series_'.word(runs, i).'/wall.csv' using 1:($2/h) with lines lw 1.5 lc rgb colours[i]
  set ylabel 'level at the wall / h'
  plot for [i = 1:words(runs)] out.'/series_'.word(runs, i).'/run_up.csv' using 1:($2/h-1) with lines lw 1.2 lc rgb colours[i]
  unset multiplot
}
