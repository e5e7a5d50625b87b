/* What the examples of waves share: a flume with a bed, a left side that may be a piston, and a
 * right side that may lean or be moved by a body. */
#ifndef EXAMPLE_FLUME_H
#define EXAMPLE_FLUME_H

#include "flow.h"

/* Initialise it with EXAMPLE_FLUME and change what the case wants; 0 stands for a default. */
typedef struct example_flume {
  double dx, depth, length; /* length: from the left side to the toe of the right */
  double height_ratio;      /* of the wave, H/d */
  double angle;             /* between bed and right side, in the water [degrees] */
  double crest;             /* --start theory: how far before the toe the crest is */
  double paddle_start;      /* --start paddle: when the piston moves [s] */
  double paddle_middle;     /* or when it is in the middle of its stroke [s] */
  double end;               /* [s] */
  double gravity, density;
  const char *theory, *start, *motion;
} example_flume;
#define EXAMPLE_FLUME \
  { .angle = 90, .gravity = 9.81, .density = 1000, .theory = "exact", .motion = "", }
#define EXAMPLE_FLUME_OPTIONS(s)                                                                 \
  OPTION_NUMBER("--dx", (s).dx, 1e-5, 1, "spacing [m]"),                                         \
      OPTION_NUMBER("--depth", (s).depth, 1e-3, 100, "depth d of still water [m]"),              \
      OPTION_NUMBER("--length", (s).length, 1e-2, 10000, "flume, to the right wall's toe [m]"),  \
      OPTION_NUMBER("--height-ratio", (s).height_ratio, 0.01, 0.79, "height of the wave, H/d"),  \
      OPTION_TEXT("--theory", (s).theory, "boussinesq, kdv, rayleigh, grimshaw, fenton, exact"), \
      OPTION_TEXT("--start", (s).start, "paddle: a piston makes the wave; theory: it is there"), \
      OPTION_TEXT("--motion", (s).motion,                                                        \
                  "CSV with the piston's t_s and x_piston_m, instead of the theory's law"),      \
      OPTION_NUMBER("--crest", (s).crest, 0, 10000, "theory: crest before the toe [m]; 20 d"),   \
      OPTION_NUMBER("--paddle-start", (s).paddle_start, 0, 1000, "paddle: when it starts [s]"),  \
      OPTION_NUMBER("--paddle-middle", (s).paddle_middle, 0, 1000,                               \
                    "instead: when it is in the middle of its stroke [s]"),                      \
      OPTION_NUMBER("--end", (s).end, 0, 10000, "end [s]; 0: after the run-up")

/* Walls in the boundary: a fixed right wall is part of the bed's, on which the horizontal force is that on
 * the right wall. */
enum { FLUME_BED, FLUME_LEFT, FLUME_RIGHT };

typedef struct example_waves {
  sph_wave *wave;
  sph_paddle *paddle; /* NULL without one */
  bool flap;          /* the paddle is one, hinged at the bed */
} example_waves;

/* How the flumes are computed unless told otherwise. Wendland's C2 with h = 2 dx holds steep run-up together best; alpha = 0.01 loses less of a wave than 0.02, and below it the pressure scatters: docs/wave_loss.md. */
example_scheme example_flume_scheme(void);

/* Refuses options that do not go together and fills in defaults. */
void example_flume_complete(example_flume *s);

/* Everything up to the integrator with the waves as they are: still water where there is a paddle. A body,
 * if any, moves the right wall along +x. Sound speed: the scheme's factor times sqrt(g (d + H)). */
void example_flume_build(const example_flume *s, const example_scheme *scheme, sph_body *body,
                         example_flow *f, const example_waves *w);
/* The same with a solitary wave as the options say. */
void example_flume_create(const example_flume *s, const example_scheme *scheme, sph_body *body,
                          example_flow *f, example_waves *w);
void example_waves_destroy(example_waves *w);

/* Lets the first `count` probes sample every 0.02 sqrt(d/g), from now on but for number `force` (-1: none), since
 * nothing has pushed yet; prepares frames for ParaView if there are to be any. */
void example_flume_watch(const example_flume *flume, example_flow *f, int count, int force, int vtk,
                         const char *folder);
/* Steps to the end, with frames for ParaView and as text for gnuplot in the folder. */
sph_status example_flume_run(const example_flume *flume, example_flow *f, double end, int vtk,
                             int pictures, const char *folder);
/* Particles behind a wall, by the walls' own distance. */
int64_t example_flume_count_lost(const example_flow *f);

/* A point on the right wall as it was created, at a height above the bed. */
void example_flume_on_wall(const example_flume *s, double height, double *point);

/* When the crest of the wave would meet the toe. */
double example_flume_arrival(const example_flume *s, const example_waves *w);

#endif
