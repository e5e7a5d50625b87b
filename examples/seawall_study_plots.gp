# Plots of a study of seawalls, as figures 13-15 of Liang et al. (2017): largest displacement, force and run-up over
# the spring's stiffness, a panel a mass, a curve a wave.
#
#   gnuplot -e "study='seawall_study.csv'; images='folder'" seawall_study_plots.gp
#
# images: where seawall_displacement.png, seawall_force.png and seawall_run_up.png go; runs that failed leave gaps.
set datafile separator ','
set terminal pngcairo size 1050,620 font 'DejaVu Sans,10' noenhanced
set border 3 lw 1.2
set tics nomirror out
set xtics 2
set grid lc rgb '#dddddd' lt 1
rho = 1000.0; g = 9.81; h = 0.2

values(column) = system(sprintf("awk -F, '/^[0-9]/ { print $%d }' '%s' | sort -g -u | tr '\\n' ' '", column, study))
heights = values(1); masses = values(3)
# Rows of a wave and a wall; k = 0 has no logarithm. Numbers as the file has them.
rows(height, mass) = sprintf("< awk -F, '$1 == \"%s\" && $3 == \"%s\" && $2 > 0' '%s'", height, mass, study)
panel_rows = (words(masses) + 2) / 3
panel_columns = words(masses) < 3 ? words(masses) : 3
array colours[5] = ['#9ecae1', '#4292c6', '#08519c', '#e6550d', '#a63603']
colour(n) = colours[(n - 1) % 5 + 1]

array column[3] = [9, 4, 6]
array quantity[3] = ['largest displacement / h', 'largest force / static force', 'largest run-up / h']
array image[3] = ['displacement', 'force', 'run_up']
do for [n = 1:3] {
  set yrange [*:*]
  stats study using (valid(column[n]) ? column(column[n]) : NaN) nooutput
  top = STATS_max > 0 ? 1.05 * STATS_max : 1
  set output sprintf('%s/seawall_%s.png', images, image[n])
  set multiplot layout panel_rows, panel_columns
  set yrange [0:top]
  set xlabel 'log10 k / (rho g h^2)'
  set ylabel quantity[n]
  do for [p = 1:words(masses)] {
    set title sprintf('m / (rho h^2) = %g', word(masses, p) / (rho * h * h))
    if (n == 1) { set key top right title 'H/h' samplen 2 } else { set key top left title 'H/h' samplen 2 }
    if (p > 1) { unset key }
    plot for [i = 1:words(heights)] rows(word(heights, i), word(masses, p)) \
           using (log10($2 / (rho * g * h * h))):column[n] with linespoints pt 7 ps 0.6 lw 1.5 lc rgb colour(i) \
           title word(heights, i)
  }
  unset multiplot
}
