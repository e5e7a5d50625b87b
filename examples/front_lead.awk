# Compares a computed front with a measured one.
#
#   awk -f front_lead.awk -v L=0.146 MEASURED.csv FRONT.csv
#
# MEASURED: T = t sqrt(2 g/L) and Z = x/L; FRONT: t [s] and x [m]. Only the accelerating part up to the
# largest Z of both counts. Prints: points; mean lead of the computed front, T_measured - T_computed at
# the same Z; standard deviation of that lead; mean of Z_computed / Z_measured - 1 at the same T.
BEGIN { FS = "," }
/^#/ || !/^[0-9]/ { next }
FNR == NR { T[++n] = $1; Z[n] = $2; next }
{
  t = $1 * sqrt(2 * 9.81 / L); z = $2 / L
  if (z > top) top = z
  for (k = 1; k <= n; k++) {
    if (!(k in reach) && z >= Z[k]) reach[k] = m ? before_t + (t - before_t) * (Z[k] - before_z) / (z - before_z) : t
    if (!(k in at) && t >= T[k]) at[k] = m ? before_z + (z - before_z) * (T[k] - before_t) / (t - before_t) : z
  }
  before_t = t; before_z = z; m++
}
END {
  for (k = 1; k <= n; k++) {
    if (T[k] == 0 || !(k in reach) || Z[k] > 0.99 * top) continue
    lead = T[k] - reach[k]
    points++; sum += lead; square += lead * lead
    ratio += (k in at) ? at[k] / Z[k] - 1 : 0
  }
  if (points < 2) { print "0 nan nan nan"; exit }
  mean = sum / points
  spread = square / points - mean * mean
  printf "%d %.3f %.3f %.4f\n", points, mean, sqrt(spread > 0 ? spread : 0), ratio / points
}
