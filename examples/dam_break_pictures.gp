# The flow coloured by pressure: one PNG a frame, and all of them on a sheet.
#
#   gnuplot -e "run='folder'; images='folder'; frames=11; tank=5.366; top=2" dam_break_pictures.gp
#
# Lengths are in column heights. A particle is a disc of one spacing. width is that of the sheet in
# pixels.
if (!exists('width')) width = 1260
file(k) = sprintf('%s/picture_%03d.txt', run, k)
word_of(k, n) = system(sprintf("awk 'NR == 1 { print $%d }' '%s'", n, file(k))) + 0
radius = 0.56 * word_of(0, 5)
set palette defined (0 '#30123b', 0.12 '#4458cb', 0.28 '#2ab5e8', 0.42 '#25e0a8', 0.56 '#83f659', \
  0.7 '#dfd23a', 0.84 '#f9812d', 0.95 '#c82803', 1 '#7a0403')
set cbrange [0:1]
set size ratio -1
unset key
set style fill solid noborder
set border 0
set object 1 polygon from 0,top to 0,0 to tank,0 to tank,top to tank+0.04,top to tank+0.04,-0.04 \
  to -0.04,-0.04 to -0.04,top to 0,top fillstyle solid noborder fillcolor rgb '#555555'
set xrange [-0.06:tank+0.06]; set yrange [-0.06:top]

do for [k=0:frames-1] {
  set terminal pngcairo size 1100,440 font 'DejaVu Sans,12' noenhanced
  set output sprintf('%s/flow_%03d.png', images, k)
  set title sprintf('t sqrt(g/H) = %.2f', word_of(k, 3))
  set xlabel 'x / H'; set ylabel 'y / H'
  set xtics 1 out nomirror; set ytics 0.5 out nomirror
  set cblabel 'p / (rho g H)'
  plot file(k) using 1:2:(radius):3 with circles lc palette
}

columns = 3
rows = int((frames + 1 + columns - 1) / columns)
set terminal pngcairo size width,rows*(0.94*width/columns*top/tank+44) font sprintf('DejaVu Sans,%d', width < 1000 ? 8 : 10) noenhanced
set output images.'/flow.png'
unset xlabel; unset ylabel; unset xtics; unset ytics
unset colorbox
set multiplot layout rows,columns margins 0.01,0.99,0.01,0.96 spacing 0.015,0.05
do for [k=0:frames-1] {
  set title sprintf('t sqrt(g/H) = %.2f', word_of(k, 3)) offset 0,-0.7
  plot file(k) using 1:2:(radius):3 with circles lc palette
}
# The last place holds the colours.
unset object 1
unset title
set colorbox horizontal user origin screen 0.70,0.09 size screen 0.26,0.035
set cblabel 'pressure / (rho g H)' offset 0,0.3
set cbtics 0.25
set label 1 'particles are discs of one spacing' at screen 0.83,0.17 center
plot [0:1][0:1] 2 with points palette
unset multiplot
