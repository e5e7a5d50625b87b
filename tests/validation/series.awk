# One figure of a column of comma-separated values, over the time in another: rows start with a number.
#
#   awk -f series.awk -v column=2 -v what=most [-v time=1] [-v scale=1] [-v offset=0] [-v window=0]
#       [-v level=0] [-v from=-1e9] FILE
#
# Values are (value - offset) scale, and means over a window of time. what: most, most_at (its time), last,
# rises (when level is reached first), falls (when it is left downwards first, after from); "" if never.
BEGIN {
  FS = ","
  if (time == "") time = 1
  if (scale == "") scale = 1
  if (from == "") from = -1e9
  n = head = tail = 0
}
/^[-+.0-9]/ { t[n] = $time + 0; v[n++] = ($column - offset) * scale }
END {
  for (k = 0; k < n; k++) {
    while (head < n && t[head] <= t[k] + window / 2) sum += v[head++]
    while (t[tail] < t[k] - window / 2) sum -= v[tail++]
    mean = sum / (head - tail)
    if (k == 0 || mean > most) { most = mean; most_at = t[k] }
    if (rises == "" && mean >= level) rises = t[k]
    if (falls == "" && t[k] >= from && mean < level) falls = t[k]
  }
  if (what == "most") print most
  if (what == "most_at") print most_at
  if (what == "last") print mean
  if (what == "rises") print rises
  if (what == "falls") print falls
}
