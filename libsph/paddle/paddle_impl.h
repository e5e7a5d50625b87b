/* Wave makers from the inside: a law gives the motion, the handle knows when and what moves. */
#ifndef SPHI_PADDLE_IMPL_H
#define SPHI_PADDLE_IMPL_H

#include <sph/paddle.h>
#include <sph/wave.h>

#include "core/internal.h"

#define SPHI_PI 3.14159265358979323846

/* A law of motion: one table at the end of its file. */
typedef struct sphi_paddle_law {
  sph_paddle_type type;
  size_t size; /* bytes of paddle->data, zeroed at creation */
  /* Displacement, velocity and acceleration `since` the start, 0 < since < paddle->duration. */
  void (*at)(const sph_paddle *paddle, double since, double *motion);
  /* Before the wave maker becomes a flap with this hinge: takes that in, or refuses and changes
   * nothing. NULL: the displacement does not depend on what moves. */
  sph_status (*reshape)(sph_paddle *paddle, double hinge);
  void (*release)(sph_paddle *paddle); /* what data holds; NULL: nothing */
} sphi_paddle_law;

struct sph_paddle {
  sph_context *context;
  const sphi_paddle_law *law;
  void *data; /* the law's own */
  double start, duration, stroke;
  double before, after; /* displacement at rest */
  double depth;         /* of still water [m], 0: not known */
  bool flap;
  double hinge; /* of a flap, above the bed [m] */
};

/* A paddle without its numbers; sph_paddle_destroy() frees it also while data is half filled. */
sph_status sphi_paddle_new(sph_context *context, const sphi_paddle_law *law, sph_paddle **out);
const char *sphi_paddle_name(const sphi_paddle_law *law);

/* The first lines of every create function: out and context. */
#define SPHI_PADDLE_BEGIN(context, law, out) \
  if (out) *(out) = NULL;                    \
  if (!(context)) return SPH_E_ARGUMENT;     \
  SPH_CHECK((context), out, SPH_E_ARGUMENT, "paddle \"%s\": out is NULL", sphi_paddle_name(&(law)))

/* A number that a create function checks. */
typedef struct sphi_paddle_value {
  const char *name, *unit;
  double value;
} sphi_paddle_value;
/* Refuses numbers that are not finite and > 0. */
sph_status sphi_paddle_check_positive(sph_context *context, const sphi_paddle_law *law, int count,
                                      const sphi_paddle_value *values);

/* ---------------------------------------------------------------------------- solitary waves */

/* An odd motion about the middle of the stroke, with smooth ends: first member of a law's data. */
typedef struct sphi_rise {
  /* The endless law at time >= 0 after the middle: displacement from there, and its rates. */
  void (*law)(const sph_paddle *paddle, double time, double *motion);
  double half; /* from the middle to rest [s] */
  double edge; /* from the middle to where the smooth end takes over [s] */
  double left; /* displacement to go there [m] */
  /* To go at the share s of the smooth end's time that is left: left s^3 (c0 + c1 s + c2 s^2). */
  double c[3];
} sphi_rise;

/* Checks a solitary wave for a law. */
sph_status sphi_rise_check(sph_context *context, const sphi_paddle_law *law, const sph_wave *wave,
                           double start_time);
/* Default ends; rise->law, paddle->stroke and what the law needs are there. */
sph_status sphi_rise_begin(sph_paddle *paddle, double start_time);
void sphi_rise_at(const sph_paddle *paddle, double since, double *motion);
sph_status sphi_rise_refuse_flap(sph_paddle *paddle, double hinge);

/* --------------------------------------------------------------------- sums of linear waves */

typedef struct sphi_component {
  double frequency, wave_number, amplitude, phase; /* eta = a cos(k x - 2 pi f t + phase) */
  double stroke;                                   /* x_b = S/2 sin(2 pi f t - phase) */
} sphi_component;

/* Data of the laws that are sums. */
typedef struct sphi_sum {
  int components;
  sphi_component *component;
  double second; /* amplitude of the second harmonic of a regular wave of order 2, or 0 */
  double ramp;   /* duration of the smooth start */
} sphi_sum;

/* Components without numbers. */
sph_status sphi_sum_begin(sph_paddle *paddle, int components, double depth, double ramp);
/* Strokes from amplitudes, for the paddle as it is or, with hinge not NULL, as a flap. */
sph_status sphi_sum_strokes(sph_paddle *paddle, const double *hinge);
void sphi_sum_at(const sph_paddle *paddle, double since, double *motion);
void sphi_sum_release(sph_paddle *paddle);
/* The data if the law is a sum, or NULL. */
sphi_sum *sphi_sum_of(const sph_paddle *paddle);

/* Height of the wave over stroke at still water level, hinge NULL: a piston. */
double sphi_paddle_transfer(double wave_number, double depth, const double *hinge);
/* Warns when waves of this height and number break. */
void sphi_paddle_warn_breaking(const sph_paddle *paddle, double height, double wave_number);

/* A spectrum cut into components. */
typedef struct sphi_sea {
  sph_spectrum spectrum;
  double peak_period, gamma, depth, gravity;
  int components;
} sphi_sea;
/* Refuses what is out of range. */
sph_status sphi_sea_check(sph_context *context, const sphi_paddle_law *law, const sphi_sea *sea);
/* Components with frequencies, wave numbers and, as amplitudes, the spectrum's values relative to its
 * greatest; *peak is the wave number at the peak. Warns of components that are too short. */
sph_status sphi_sea_fill(sph_paddle *paddle, const sphi_sea *sea, double *peak);

#endif
