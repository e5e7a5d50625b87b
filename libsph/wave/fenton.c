/* Fenton's ninth order, J. Fluid Mech. 53 (1972), 257, with S(X) = sech^2(alpha X) and
 * e = H/d:
 *
 *     c^2 = 1 + sum_n c_n e^n,   alpha^2 = (3 e/4) (1 + sum_n a_n e^n)                           (1)
 *     eta = sum_n e^n sum_{m<=n} e_nm S^m,   u(X, 0) = -c sum_n e^n sum_{m<=n} f_nm S^m          (2)
 *
 * The numbers were derived anew in rational arithmetic. Above the bed the flow is the Taylor series of a
 * flow without divergence and rotation,
 *
 *     u =  sum_j (-1)^j y^2j/(2j)! d^2j/dX^2j u(X, 0)                                 (3)
 *     v = -sum_j (-1)^j y^(2j+1)/(2j+1)! d^(2j+1)/dX^(2j+1) u(X, 0)                     (4)
 *     d^2/dX^2 S^m = alpha^2 [4 m^2 S^m - 2 m (2m + 1) S^(m+1)]                         (5)
 *
 * in which two derivatives are worth one order of e: of (2) the j-th term takes the orders n <= 9 - j.
 * With all of them the high powers of S ruin (3) near the crest, where S would be 1/cos^2(alpha y). */
#include "wave/wave_list.h"

static const double c_n[SPHI_WAVE_TERMS] = {1,
                                            -1.0 / 20,
                                            -3.0 / 70,
                                            -6.0 / 175,
                                            -2427.0 / 77000,
                                            -0.0292783645,
                                            -0.0268450678,
                                            -0.0302633588,
                                            -0.0219346752};
static const double a_n[SPHI_WAVE_TERMS - 1] = {-1.25,         1.5,           -1.8164285714,
                                                2.1437857143,  -2.5377594156, 2.9479805480,
                                                -3.4286469475, 3.9313392668};
static const double e_nm[SPHI_WAVE_TERMS][SPHI_WAVE_TERMS] = {
    {1},
    {-3.0 / 4, 3.0 / 4},
    {5.0 / 8, -151.0 / 80, 101.0 / 80},
    {-8209.0 / 6000, 11641.0 / 3000, -112393.0 / 24000, 17367.0 / 8000},
    {1.860566327, -7.451354592, 12.76378189, -11.41985906, 4.246865434},
    {-2.574133435, 13.28559537, -31.11913738, 40.10678675, -28.42715358, 8.728042273},
    {3.457170114, -22.78209814, 68.2579783, -116.9736723, 120.4899617, -71.05724393, 18.60790431},
    {-4.684868189, 37.67003888, -139.2800656, 301.4415835, -411.4157849, 355.0690622, -180.2121607,
     41.41219482},
    {6.190529333, -60.57257267, 269.842447, -712.1250498, 1217.977253, -1384.373445, 1023.072321,
     -450.2908008, 90.27931885}};
static const double f_nm[SPHI_WAVE_TERMS][SPHI_WAVE_TERMS] = {
    {-1},
    {1.0 / 4, 1},
    {1.0 / 5, -3.0 / 10, -6.0 / 5},
    {14713.0 / 42000, -5357.0 / 6000, 299.0 / 750, 197.0 / 125},
    {-0.3189829932, -0.2276632653, 1.789530612, -0.5460680272, -2.193959184},
    {0.3643700773, 0.4654432313, 0.07679435374, -3.210607075, 0.7063782313, 3.211994558},
    {-0.3533893517, -0.1174781741, -1.228068831, 0.1607496433, 5.426153465, -0.5392486564,
     -5.045741635},
    {0.4365090345, 0.1201614735, -0.08401301744, 2.940433931, -0.8775544686, -7.319150096,
     -2.783316954, 9.400753441},
    {-0.4300665814, -0.2258605885, 0.2310211164, 0.2571340283, -7.159835874, 9.896019278,
     -13.53244857, 36.99096196, -27.99824305}};

static double power_series(int terms, const double *coefficients, double e) {
  double sum = 0;
  for (int n = terms; n >= 1; n--) sum = (sum + coefficients[n - 1]) * e;
  return sum;
}

/* d^2j/dX^2j u(X, 0) as a series in S: orders up to 9 - j of (2), and (5) j times. */
static void bed_derivative(const sph_wave *wave, int j, double *series) {
  const double square = wave->decay * wave->decay;
  for (int n = 1; n <= SPHI_WAVE_TERMS - j; n++)
    for (int m = 0; m < n; m++) series[m] -= wave->celerity * pow(wave->ratio, n) * f_nm[n - 1][m];
  for (int k = 0; k < j; k++)
    for (int m = SPHI_WAVE_TERMS; m >= 1; m--)
      series[m - 1] = square * (4.0 * m * m * series[m - 1] -
                                (m > 1 ? 2.0 * (m - 1) * (2 * m - 1) * series[m - 2] : 0));
}

static sph_status prepare(sph_wave *wave) {
  const double e = wave->ratio;
  wave->celerity = sqrt(1 + power_series(SPHI_WAVE_TERMS, c_n, e));
  wave->decay = sqrt(0.75 * e * (1 + power_series(SPHI_WAVE_TERMS - 1, a_n, e)));
  for (int n = 1; n <= SPHI_WAVE_TERMS; n++)
    for (int m = 0; m < n; m++) wave->elevation[m] += pow(e, n) * e_nm[n - 1][m];
  for (int j = 0; j < SPHI_WAVE_TERMS; j++) bed_derivative(wave, j, wave->bed[j]);
  wave->volume = sphi_wave_series_volume(wave);
  return SPH_OK;
}

static void velocity(const sph_wave *wave, double X, double y, double *w) {
  const double C = cosh(wave->decay * X), S = 1 / (C * C), T = tanh(wave->decay * X);
  double u = 0, v = 0, weight = 1; /* (-1)^j y^2j/(2j)! */
  for (int j = 0; j < SPHI_WAVE_TERMS; j++) {
    double even = 0, odd = 0; /* d^2j u, and its derivative but for -2 alpha T */
    for (int m = SPHI_WAVE_TERMS; m >= 1; m--) {
      even = (even + wave->bed[j][m - 1]) * S;
      odd = (odd + m * wave->bed[j][m - 1]) * S;
    }
    u += weight * even;
    v += weight / (2 * j + 1) * odd;
    weight *= -y * y / ((2 * j + 1) * (2 * j + 2));
  }
  w[0] = u;
  w[1] = 2 * wave->decay * T * y * v;
}

const sphi_wave_theory sphi_wave_fenton = {
    .name = "fenton",
    .summary = "ninth order in H/d",
    .source = "Fenton (1972)",
    .good_to = 0.6,
    .known_to = 0.8332,
    .prepare = prepare,
    .profile = sphi_wave_series_profile,
    .velocity = velocity,
    .pressure = sphi_wave_bernoulli,
};
