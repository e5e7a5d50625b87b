# Histories of a tank at rest.
#
#   gnuplot -e "run='folder'; images='folder'; name='box'" hydrostatic_plots.gp
H = 0.3; g = 9.81; rho = 1000.0
set datafile separator ','
set terminal pngcairo size 900,540 font 'DejaVu Sans,12' noenhanced
set border 3 lw 1.2
set tics nomirror out
set grid lc rgb '#dddddd' lt 1
set xlabel 't [s]'
set autoscale xfixmax
set key outside right top spacing 1.3

set output images.'/hydrostatic_'.name.'_pressure.png'
set title 'Pressure on the left wall, lines of black dots: rho g (H - y)'
set ylabel 'p [Pa]'
set yrange [0:3300]
height(k) = word('0 0.1 0.2 0.25', k + 1) + 0
colour(k) = word('#08519c #31a354 #d94801 #756bb1', k + 1)
plot for [k=0:3] sprintf('%s/p%d.csv', run, k) using 1:2 with lines lw 1.5 lc rgb colour(k) title sprintf('P%d, y = %g m', k, height(k)), \
     for [k=0:3] rho*g*(H-height(k)) with lines lw 1.5 dt 3 lc rgb 'black' notitle

set output images.'/hydrostatic_'.name.'_kinetic.png'
set title 'Kinetic energy of the water at rest'
set ylabel 'J/m'
set yrange [*:*]
set logscale y
set format y '10^{%L}'
set termoption enhanced
unset key
plot run.'/energy.csv' using 1:($2 > 0 ? $2 : NaN) with lines lw 1 lc rgb '#08519c'
