# Figures of a column of comma-separated values that series.awk does not have.
#
#   awk -f liang.awk -v column=2 -v what=at -v from=4 [-v time=1] [-v scale=1] [-v offset=0] [-v window=0] FILE
#
# Values are (value - offset) scale, and means over a window of time. what:
#   at      at time `from`, between samples by a straight line
#   mean    from `from` to `to`
#   away    largest distance from `level` between `from` and `to`
#   second  a second maximum 0.143 (sqrt(h/g) in 0.2 m of water) to `reach` (0.5) s from the largest value, by at least
#           0.01 of itself above the lowest value between the two; second_at: its time less that of the largest
# "" where there is none.
BEGIN {
  FS = ","
  if (time == "") time = 1
  if (scale == "") scale = 1
  if (reach == "") reach = 0.5
  n = head = tail = 0
}
function look(lo, hi, step,    k, least) {
  least = m[lo]
  for (k = lo; step * (hi - k) >= 0 && k >= 0 && k < n; k += step) {
    if (m[k] < least) least = m[k]
    if (step * (t[k] - t[top]) > 0.143 && m[k] - least >= 0.01 * m[k] && (second == "" || m[k] > second)) { second = m[k]; second_at = t[k] - t[top] }
  }
}
/^[-+.0-9]/ { t[n] = $time + 0; v[n++] = ($column - offset) * scale }
END {
  for (k = 0; k < n; k++) {
    while (head < n && t[head] <= t[k] + window / 2) sum += v[head++]
    while (t[tail] < t[k] - window / 2) sum -= v[tail++]
    m[k] = sum / (head - tail)
    if (k == 0 || m[k] > m[top]) top = k
    if (k > 0 && t[k - 1] <= from && t[k] >= from && t[k] > t[k - 1])
      at = m[k - 1] + (m[k] - m[k - 1]) * (from - t[k - 1]) / (t[k] - t[k - 1])
    if (t[k] < from || (to != "" && t[k] > to)) continue
    total += m[k]
    count++
    distance = m[k] > level ? m[k] - level : level - m[k]
    if (distance > away) away = distance
  }
  if (what == "at" && at == "" && n > 0 && from > t[n - 1] && from < t[n - 1] + 0.01) at = m[n - 1]
  if (what == "at") print at
  if (what == "mean") print count ? total / count : ""
  if (what == "away") print away
  for (last = top; last < n - 1 && t[last] < t[top] + reach;) last++
  for (first = top; first > 0 && t[first] > t[top] - reach;) first--
  look(top, last, 1)
  look(top, first, -1)
  if (what == "second") print second
  if (what == "second_at") print second_at
}
