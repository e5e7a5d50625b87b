# Pictures of the comparison of interpolators.
#
#   gnuplot -e "runs='folder'; images='folder'; measured='tests/data'; dx=0.01; frame='picture_025.txt'" interpolators.gp
H = 0.3; g = 9.81; rho = 1000.0
kinds = 'improved-shepard tuned-shepard normalized sfdi mls-linear mls-quadratic'
colour(k) = word('#08519c #6baed6 #d94801 #31a354 #756bb1 #c51b8a', k)
set datafile separator ','
set datafile commentschars '#'
set border 3 lw 1.2
set tics nomirror out
set grid lc rgb '#dddddd' lt 1

set terminal pngcairo size 900,640 font 'DejaVu Sans,10' noenhanced
set output images.'/interpolator_rest.png'
height(k) = word('0 0.1 0.2 0.25', k + 1) + 0
set multiplot layout 2,2 title 'Water at rest: pressure on the left wall, dashed: rho g (H - y)'
set xlabel 't [s]'
set ylabel 'p [Pa]'
set autoscale xfixmax
unset key
do for [k=0:3] {
  exact = rho*g*(H - height(k))
  set title sprintf('P%d, y = %g m', k, height(k))
  set yrange [exact - 32:exact + 32]
  if (k == 2) { set key bottom left Left reverse spacing 0.95 font ',8' width -3 } else { unset key }
  plot for [m=1:6] sprintf('%s/rest_%s/p%d.csv', runs, word(kinds, m), k) using 1:2 every 3 with lines lw 1 lc rgb colour(m) title word(kinds, m), \
       exact with lines lw 1.5 dt 2 lc rgb 'black' notitle
}
unset multiplot
unset title

H = 0.6
set terminal pngcairo size 1000,560 font 'DejaVu Sans,12' noenhanced
set output images.'/interpolator_p1.png'
set title 'Dam break: pressure at P1, 0.19 H above the bed, means over 0.1 sqrt(H/g)'
set xlabel 't sqrt(g/H)'
set ylabel 'p / (rho g H)'
set xrange [2:7.4]; set yrange [-0.1:1.9]
set key top left box lc rgb '#cccccc' spacing 1.15 width 1 opaque
mean_of(file) = sprintf("< awk -F, -v w=%g '/^[0-9]/ { k = int($1/w); if (k != last && n) { print (last + 0.5)*w \",\" sum/n; n = sum = 0 } last = k; sum += $2; n++ }' '%s'", 0.1*sqrt(H/g), file)
plot for [m=1:6] mean_of(sprintf('%s/dam_%s/p1_edge.csv', runs, word(kinds, m))) using ($1*sqrt(g/H)):($2/(rho*g*H)) with lines lw 1.6 lc rgb colour(m) title word(kinds, m), \
     mean_of(runs.'/plain_normalized_p1.csv') using ($1*sqrt(g/H)):($2/(rho*g*H)) with lines lw 1.6 dt 3 lc rgb colour(3) title 'normalized, not compensated', \
     measured.'/dambreak_buchner_2002_wall_pressure.csv' using 1:2 with points pt 6 ps 0.9 lw 1.5 lc rgb 'black' title 'measured, Buchner (2002)'

set datafile separator whitespace
set terminal pngcairo size 740,240 font 'DejaVu Sans,8' noenhanced
set output images.'/interpolator_corner.png'
set palette defined (0 '#30123b', 0.12 '#4458cb', 0.28 '#2ab5e8', 0.42 '#25e0a8', 0.56 '#83f659', \
  0.7 '#dfd23a', 0.84 '#f9812d', 0.95 '#c82803', 1 '#7a0403')
set size ratio -1
set style fill solid noborder
unset key; unset grid
set border 0
wall = 5.366; span = 0.45
radius = 0.56*dx/H
set xrange [wall - span:wall + 0.03]; set yrange [-0.03:span]
set object 1 polygon from wall - span,0 to wall,0 to wall,span to wall + 0.03,span to wall + 0.03,-0.03 \
  to wall - span,-0.03 to wall - span,0 fillstyle solid noborder fillcolor rgb '#555555'
set tics out nomirror; set xtics 0.2; set ytics 0.2
set xlabel 'x / H' offset 0,0.3; set ylabel 'y / H' offset 1.5,0
set cbrange [0:0.9]
set cblabel 'p / (rho g H)' offset -0.5,0
set multiplot layout 1,4 margins 0.075,0.9,0.17,0.9 spacing 0.025,0.05
unset colorbox
file(m) = m == 1 ? runs.'/plain_normalized_10.txt' : sprintf('%s/dam_%s/%s', runs, word('normalized improved-shepard mls-quadratic', m - 1), frame)
do for [m=1:4] {
  set title m == 1 ? 'normalized, not compensated' : word('normalized improved-shepard mls-quadratic', m - 1)
  if (m > 1) { unset ylabel; set format y '' }
  if (m == 4) { set colorbox user origin screen 0.915,0.2 size screen 0.014,0.64 }
  plot file(m) using 1:2:(radius):3 with circles lc palette
}
unset multiplot
