# Plots of methods.sh. `out` and `images` are given.
set terminal pngcairo size 1000,420 font ',10'
set datafile separator ','
set key outside right top samplen 2
methods = 'flip isph wcsph'
title_of(m) = m eq 'flip' ? 'particles and a mesh' : m eq 'isph' ? 'incompressible SPH' : '{/Symbol d}-SPH'
file(run, m) = sprintf('%s/%s_%s/gauges.csv', out, run, m)

set output images.'/methods_standing.png'
k = 2 * pi / 20
omega = sqrt(9.81 * k * tanh(k * 5))
set xlabel 't / T'
set ylabel 'mode [m]'
plot [0:4.5] 0.25 * cos(2 * pi * x) with lines lc rgb '#999999' dt 2 title 'linear theory', \
  for [m in methods] file('standing', m) using ($1 * omega / (2 * pi)):6 with lines lw 1.5 title title_of(m)

set output images.'/methods_solitary.png'
set multiplot layout 1,2
set xlabel 't [s]'
set ylabel 'elevation / H at 9 m'
set key inside left top
do for [h in '0.2 0.35'] {
  set title 'H/d = '.h
  plot [3:8] [-0.1:1.25] for [m in methods] file('solitary_'.h, m) \
    using 1:(($4 - 0.3) / (0.3 * h)) with lines lw 1.5 title title_of(m)
}
unset multiplot

set output images.'/methods_bar.png'
set terminal pngcairo size 1500,470 font ',9'
set datafile separator whitespace
set multiplot layout 3,3
unset key
unset xlabel
unset ylabel
unset colorbox
set size ratio -1
set palette defined (0 '#1f4e79', 1 '#66b2ff', 2 '#ffffff')
set cbrange [0:3]
set style fill solid
set ytics 0.4
set xtics 1
bed(x) = x < 6 ? 0 : x < 7.5 ? (x - 6) / 6 : x < 9.5 ? 0.25 : x < 11 ? 0.25 - (x - 9.5) / 6 : 0
do for [n = 9:11] {
  do for [m in methods] {
    set title sprintf('%s, %.1f s', title_of(m), 0.5 * n)
    plot [6.5:12.5] [0:0.95] sprintf('%s/bar_%s/picture_%03d.txt', out, m, n) using 1:2:3 \
      with points pt 7 ps (m eq 'flip' ? 0.15 : 0.25) palette, bed(x) with filledcurves y1=0 lc rgb '#777777'
  }
}
unset multiplot
