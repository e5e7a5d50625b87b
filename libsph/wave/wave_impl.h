/* Waves from the inside: the table that a theory fills, and what paddles need of a wave.
 *
 * A theory works in units of depth and gravity, d = g = rho = 1, in which speeds are in sqrt(g d). X
 * is the distance ahead of the crest, y the height above the bed, eta the elevation above still water.
 */
#ifndef SPHI_WAVE_IMPL_H
#define SPHI_WAVE_IMPL_H

#include <sph/wave.h>

#include "core/internal.h"

enum { SPHI_WAVE_TERMS = 9 };

typedef struct sphi_wave_theory {
  const char *name, *summary, *source;
  double good_to;  /* H/d above which more than 10 % of H are wrong; 0: a regular wave */
  double known_to; /* H/d above which there is no wave, or INFINITY */
  /* Fills celerity, decay, volume and what the functions below need, from `ratio` or `wave_number`. */
  sph_status (*prepare)(sph_wave *wave);
  void (*release)(sph_wave *wave); /* OPTIONAL: takes back what prepare allocated */
  /* eta and d eta/dX */
  void (*profile)(const sph_wave *wave, double X, double *elevation, double *slope);
  /* (u, v) where 0 <= y <= 1 + eta(X) */
  void (*velocity)(const sph_wave *wave, double X, double y, double *velocity);
  /* p where 0 <= y <= 1 + eta(X) */
  double (*pressure)(const sph_wave *wave, double X, double y);
} sphi_wave_theory;

typedef struct sphi_wave_map sphi_wave_map; /* the exact wave: exact.c */

struct sph_wave {
  sph_context *context;
  int references;
  const sphi_wave_theory *theory;
  double height, depth, gravity; /* m, m, m/s^2 */
  double x0, t0;                 /* a crest is here [m] at this time [s] */
  int direction;
  double speed; /* sqrt(g d) [m/s] */
  /* In units of depth and gravity; NAN where the kind of wave has none. */
  double ratio;       /* H/d */
  double celerity;    /* c */
  double decay;       /* kappa: eta falls as exp(-2 kappa |X|) */
  double volume;      /* integral of eta */
  double wave_number; /* k */
  /* Coefficients of S^1, S^2 .. with S = sech^2(kappa X): of eta, and of the derivatives d^2j/dX^2j of
   * u at the bed. */
  double elevation[SPHI_WAVE_TERMS], bed[SPHI_WAVE_TERMS][SPHI_WAVE_TERMS];
  sphi_wave_map *map; /* of the exact wave */
};

void sphi_wave_retain(sph_wave *wave);
bool sphi_wave_is_solitary(const sph_wave *wave);
/* Celerity [m/s]. */
double sphi_wave_celerity(const sph_wave *wave);
/* Elevation [m] and d eta/dX at the distance `ahead` [m] of the crest, whatever its origin. */
void sphi_wave_profile(const sph_wave *wave, double ahead, double *elevation, double *slope);

/* A wave with one reference and no origin. */
sph_status sphi_wave_new(sph_context *context, const sphi_wave_theory *theory,
                         const sph_wave *values, sph_wave **out);

/* Bernoulli's equation in the frame of the wave, p = (c^2 - q^2)/2 - (y - 1), for the velocity of the
 * theory. */
double sphi_wave_bernoulli(const sph_wave *wave, double X, double y);
/* The series wave->elevation, which has no higher powers than the theory filled. */
void sphi_wave_series_profile(const sph_wave *wave, double X, double *elevation, double *slope);
double sphi_wave_series_volume(const sph_wave *wave);

#endif
