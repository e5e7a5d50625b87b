#include "flops.h"

#include <math.h>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

/* ------------------------------------------------------------------------------------ counts */

/* x_i - x_j, its square, (dW/dr)/r and this times the volume. */
static int of_geometry(int dim, sph_kernel_type kernel) {
  const int slope = kernel == SPH_KERNEL_GAUSSIAN ? 3 : 6;
  return dim + (2 * dim - 1) + slope + 1;
}

/* (u_j - u_i) . (x_i - x_j) */
static int of_approach(int dim) { return 3 * dim - 1; }

/* One more term of a sum of numbers, and of vectors along x_i - x_j. */
enum { OF_SUM = 2 };
static int of_vector_sum(int dim) { return OF_SUM * dim; }

flops flops_of_pair(int dim, sph_kernel_type kernel) {
  const int geometry = of_geometry(dim, kernel), approach = of_approach(dim);
  const int divergence = approach + OF_SUM;
  const int pressure = 2; /* p_i + p_j and this times the weight */
  const int moments = dim + OF_SUM * dim * (dim + 1) / 2, difference = 2;
  const int viscosity = approach + 3; /* over the distance's square, times a constant, added */
  const int psi = 2 + 3 * dim;
  return (flops){.gradient = geometry + divergence + difference + of_vector_sum(dim) + moments,
                 .rates = geometry + pressure + viscosity + of_vector_sum(dim) + psi + OF_SUM,
                 .convective = geometry + divergence + pressure + of_vector_sum(dim)};
}

flops flops_of_ghost(int dim, sph_kernel_type kernel) {
  const int geometry = of_geometry(dim, kernel), divergence = of_approach(dim) + OF_SUM;
  const int push = 2 + of_vector_sum(dim);
  return (flops){.gradient = geometry + divergence,
                 .rates = geometry + push,
                 .convective = geometry + divergence + push};
}

/* -------------------------------------------------------------------------------------- peak */

/* As many chains as hide the latency of two units and leave two of sixteen registers. */
enum { CHAINS = 12, ROUNDS = 1 << 19, BURSTS = 5 };

typedef float vector4 __attribute__((vector_size(16)));

static inline vector4 multiply_add(vector4 x, vector4 a, vector4 b) { return x * a + b; }
static inline vector4 set_4(float x) { return x - (vector4){0}; }

/* Rounds of x = a x + b, which stays finite; returns something that needs them all. */
#define PEAK_LOOP(name, attributes, vector, set, fma)             \
  attributes static float name(float seed) {                      \
    const vector a = set(0.999f * seed), b = set(0.001f * seed);  \
    vector x[CHAINS], sum = set(0);                               \
    for (int k = 0; k < CHAINS; k++) x[k] = set((float)k * seed); \
    for (int round = 0; round < ROUNDS; round++)                  \
      for (int k = 0; k < CHAINS; k++) x[k] = fma(x[k], a, b);    \
    for (int k = 0; k < CHAINS; k++) sum = fma(x[k], a, sum);     \
    return ((const float *)&sum)[0];                              \
  }

PEAK_LOOP(loop_baseline, , vector4, set_4, multiply_add)
#if defined(__x86_64__)
PEAK_LOOP(loop_avx2, __attribute__((target("avx2,fma"))), __m256, _mm256_set1_ps, _mm256_fmadd_ps)
PEAK_LOOP(loop_avx512, __attribute__((target("avx512f"))), __m512, _mm512_set1_ps, _mm512_fmadd_ps)
#endif

typedef struct peak_loop {
  float (*run)(float seed);
  int lanes;
} peak_loop;

static peak_loop peak_loop_of(sph_isa isa) {
#if defined(__x86_64__)
  if (isa == SPH_ISA_AVX2) return (peak_loop){loop_avx2, 8};
  if (isa == SPH_ISA_AVX512) return (peak_loop){loop_avx512, 16};
#endif
  (void)isa;
  return (peak_loop){loop_baseline, 4};
}

double flops_peak(sph_isa isa, int threads) {
  const peak_loop loop = peak_loop_of(isa);
  double best = 0;
  for (int burst = 0; burst < BURSTS; burst++) {
    volatile float seed = 1;
    float used = 0;
    int ran = 0;
    const double begin = clock_now();
#pragma omp parallel num_threads(threads) reduction(+ : used, ran)
    {
      used += loop.run(seed);
      ran++;
    }
    const double seconds = clock_now() - begin;
    seed = used;
    best = fmax(best, 1e-9 * ran * loop.lanes * CHAINS * 2.0 * ROUNDS / seconds);
  }
  (void)threads;
  return best;
}
