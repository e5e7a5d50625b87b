# Shell functions of demo.sh and the validation: figures of summaries, rows of a table, its two forms.
# Sourced, with `rows` naming the file that collects the rows.

# figure SUMMARY.json KEY: its value, "null" if it is not there.
figure() {
  value=$(sed -n "s/^ *\"$2\": *\"\{0,1\}\([^\",]*\)\"\{0,1\},\{0,1\}\$/\1/p" "$1" 2>/dev/null)
  echo "${value:-null}"
}

# scaled FACTOR VALUE
scaled() { awk -v f="$1" -v x="$2" 'BEGIN { if (x == "null") print x; else printf "%.4g\n", f * x }'; }

# row QUANTITY VALUE LOWEST HIGHEST REFERENCE: one figure and the bar that it must stay in.
row() {
  printf '%s\t%s\t%s\t%s\t%s\n' "$1" "$2" "$3" "$4" "$5" | awk -F'\t' -v OFS='\t' '
    { ok = $2 ~ /^[-+.0-9]/ && $2 + 0 >= $3 + 0 && $2 + 0 <= $4 + 0
      value = $2 ~ /^[-+.0-9]/ ? sprintf("%.4g", $2) : "none"
      bar = $3 == $4 ? $3 : ($3 == 0 ? "at most " $4 : $3 " to " $4)
      print $1, value, bar, $5, ok ? "yes" : "NO" }' >>"$rows"
}

# row_without_bar QUANTITY VALUE REFERENCE: one figure that is reported alone.
row_without_bar() {
  printf '%s\t%s\t%s\n' "$1" "$2" "$3" | awk -F'\t' -v OFS='\t' '
    { print $1, $2 ~ /^[-+.0-9]/ ? sprintf("%.4g", $2) : "none", "none", $3, "-" }' >>"$rows"
}

rows_failed() { awk -F'\t' '$5 == "NO"' "$rows" | wc -l | tr -d ' '; }

rows_as_text() {
  awk -F'\t' '{ printf "  %-4s %-62s %10s   (%s)\n", $5 == "yes" ? "ok" : "MISS", $1, $2, $3 }' "$rows"
}

rows_as_markdown() {
  echo '| quantity | computed | bar | reference | within |'
  echo '|---|---|---|---|---|'
  awk -F'\t' '{ printf "| %s | %s | %s | %s | %s |\n", $1, $2, $3, $4, $5 == "NO" ? "**no**" : $5 }' "$rows"
}

rows_as_html() {
  echo '<table><tr><th>quantity<th>computed<th>bar<th>reference<th>within</tr>'
  awk -F'\t' '{ gsub(/&/, "\\&amp;"); gsub(/</, "\\&lt;")
    printf "<tr class=\"%s\"><td>%s<td>%s<td>%s<td>%s<td>%s</tr>\n", $5 == "yes" ? "yes" : "no", $1, $2, $3, $4, $5 }' "$rows"
  echo '</table>'
}

# lead FIELD L MEASURED FRONT: field 1 to 4 of front_lead.awk.
lead() { awk -f "$examples/front_lead.awk" -v L="$2" "$3" "$4" | cut -d' ' -f"$1"; }

# mean_measured FILE LO HI: mean of the measured pressure between two times.
mean_measured() {
  awk -F, -v lo="$2" -v hi="$3" '/^[0-9]/ && $1 >= lo && $1 <= hi {
    if (n++) { sum += ($1 - t) * ($2 + p) / 2; span += $1 - t }
    t = $1; p = $2 } END { print sum / span }' "$1"
}

# dam_break_rows RUN.json RUN SMALL: the rows of the dam break and of its front. RUN: H = 0.6 m;
# SMALL: L = 0.146 m, 2 L high.
dam_break_rows() {
  plateau=$(mean_measured "$measured/dambreak_buchner_2002_wall_pressure.csv" 3 5)
  koshizuka=$measured/dambreak_koshizuka_oka_1996_front_pysph.csv
  martin=$measured/dambreak_martin_moyce_n2_2_a2.25in_front_table2.csv
  row 'front reaches the right wall, t sqrt(g/H)' "$(figure "$1" front_arrival_t_star)" 2.35 2.51 'Huang et al. (2019): 2.43'
  row 'P1 (0.19 H), mean of 3 <= t sqrt(g/H) <= 5, p/(rho g H)' "$(figure "$1" p1_plateau_mean_over_rho_g_h)" \
    "$(scaled 0.85 "$plateau")" "$(scaled 1.15 "$plateau")" "Buchner (2002): $(scaled 1 "$plateau")"
  row 'mean over the plate (0.115 to 0.205 m), the same mean' "$(figure "$1" plate_plateau_mean_over_rho_g_h)" \
    "$(scaled 0.85 "$plateau")" "$(scaled 1.15 "$plateau")" "Buchner (2002): $(scaled 1 "$plateau")"
  row 'plunging jet closes the cavity, t sqrt(g/H)' "$(figure "$1" cavity_closes_t_star)" 5.80 6.16 'Huang et al. (2019): 5.98'
  row 'P1, second peak, t sqrt(g/H)' "$(figure "$1" p1_second_peak_t_star)" 5.55 6.13 \
    'Buchner (2002): 5.84'
  row 'P1, second peak / plateau' "$(awk -v a="$(figure "$1" p1_second_peak_over_rho_g_h)" \
    -v b="$(figure "$1" p1_plateau_mean_over_rho_g_h)" 'BEGIN { if (b > 0) print a / b; else print "null" }')" 1.15 3 'Buchner (2002): 1.63'
  row 'largest growth of the total energy / E(0)' "$(figure "$1" energy_growth_max_rel)" 0 0.001 'never grows'
  row 'particles that left the tank' "$(figure "$1" particles_lost)" 0 0 'none'
  row 'front, column L x L/2: mean of x/x_measured - 1' "$(lead 4 1.2 "$koshizuka" "$2/front.csv")" -0.05 0.05 'Koshizuka and Oka (1996)'
  row 'front, column L x L/2: mean of x/x_measured - 1' "$(lead 4 1.2 "$martin" "$2/front.csv")" -0.05 0.05 'Martin and Moyce (1952)'
  row 'front, column L x 2 L: mean lead in t sqrt(2 g/L)' "$(lead 2 0.146 "$koshizuka" "$3/front.csv")" 0 0.25 'Koshizuka and Oka (1996), gate'
  row 'front, column L x 2 L: mean lead in t sqrt(2 g/L)' "$(lead 2 0.146 "$martin" "$3/front.csv")" 0 0.25 'Martin and Moyce (1952), gate'
  row 'front, column L x 2 L: spread of that lead' "$(lead 3 0.146 "$martin" "$3/front.csv")" 0 0.1 'Martin and Moyce (1952)'
}
