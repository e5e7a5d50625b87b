# Plots of a dam break against measurements.
#
#   gnuplot -e "run='folder'; small='folder'; measured='tests/data'; images='folder'" dam_break_plots.gp
#
# run: a run of dam_break with H = 0.6 m (plate gauge, front, energy); small: one with the column of the
# experiments on fronts, L = 0.146 m and 2 L high.
H = 0.6; L = 1.2; l = 0.146; g = 9.81; rho = 1000.0
set datafile separator ','
set datafile commentschars '#'
set terminal pngcairo size 900,540 font 'DejaVu Sans,12' noenhanced
set border 3 lw 1.2
set tics nomirror out
set grid lc rgb '#dddddd' lt 1
set key top left box lc rgb '#cccccc' spacing 1.2 width 1 opaque

# Means over neighbouring intervals of 0.1 sqrt(H/g).
mean_of(file) = sprintf("< awk -F, -v w=%g '/^[0-9]/ { k = int($1/w); if (k != last && n) { print (last + 0.5)*w \",\" sum/n; n = sum = 0 } last = k; sum += $2; n++ }' '%s'", 0.1*sqrt(H/g), file)

set output images.'/p1_pressure.png'
set title 'Wall pressure, plate of 90 mm centred 0.16 m above the bed'
set xlabel 't sqrt(g/H)'
set ylabel 'p / (rho g H)'
set xrange [2:7.4]; set yrange [-0.2:2]
plot run.'/p1_point.csv' using ($1*sqrt(g/H)):($2/(rho*g*H)) with lines lw 0.5 lc rgb '#bdd0e5' title 'computed, point', \
     run.'/p1_plate.csv' using ($1*sqrt(g/H)):($2/(rho*g*H)) with lines lw 1 lc rgb '#4292c6' title 'computed, plate', \
     mean_of(run.'/p1_plate.csv') using ($1*sqrt(g/H)):($2/(rho*g*H)) with lines lw 2.5 lc rgb '#041c3a' title 'plate, mean over 0.1', \
     mean_of(run.'/p1_edge.csv') using ($1*sqrt(g/H)):($2/(rho*g*H)) with lines lw 2 lc rgb '#9e6bc4' title 'P1 (0.19 H), mean over 0.1', \
     measured.'/dambreak_buchner_2002_wall_pressure.csv' using 1:2 with points pt 6 ps 0.9 lw 1.5 lc rgb '#d94801' title 'measured, Buchner (2002)'

set output images.'/front.png'
set title 'Front on the dry bed'
set xlabel 't sqrt(2 g/L)'
set ylabel 'x / L'
set xrange [0:3.6]; set yrange [1:4.5]
plot small.'/front.csv' using ($1*sqrt(2*g/l)):($2/l) with lines lw 2 lc rgb '#08519c' title 'computed, column L x 2 L as in the experiments', \
     run.'/front.csv' using ($1*sqrt(2*g/L)):($2/L) with lines lw 2 dt 2 lc rgb '#6baed6' title 'computed, column L x L/2, until the wall at 2.68 L', \
     measured.'/dambreak_koshizuka_oka_1996_front_pysph.csv' using 1:2 with points pt 4 ps 1.2 lw 1.5 lc rgb '#d94801' title 'measured, Koshizuka and Oka (1996)', \
     measured.'/dambreak_martin_moyce_n2_2_a2.25in_front_table2.csv' using 1:2 with points pt 6 ps 1.2 lw 1.5 lc rgb '#31a354' title 'measured, Martin and Moyce (1952)'

set output images.'/energy.png'
set title 'Energy of the water, relative to that of the column'
set xlabel 't sqrt(g/H)'
set ylabel 'E / E(0)'
set xrange [0:7.4]; set yrange [0:1.05]
set key outside right top nobox
e0 = system(sprintf("awk -F, '/^[0-9]/ { print $5; exit }' '%s/energy.csv'", run)) + 0
plot run.'/energy.csv' using ($1*sqrt(g/H)):($5/e0) with lines lw 2 lc rgb '#252525' title 'total', \
     '' using ($1*sqrt(g/H)):($3/e0) with lines lw 2 lc rgb '#08519c' title 'potential', \
     '' using ($1*sqrt(g/H)):($2/e0) with lines lw 2 lc rgb '#d94801' title 'kinetic', \
     '' using ($1*sqrt(g/H)):($4/e0) with lines lw 1 lc rgb '#31a354' title 'compression'

set output images.'/column.png'
set title 'Height of the water at the left wall'
set ylabel 'eta / H'
set yrange [0:1.1]
set key inside top right
plot run.'/column.csv' using ($1*sqrt(g/H)):($2/H) with lines lw 2 lc rgb '#08519c' title 'computed'
