/** @file
 * Types shared by all public headers.
 */
#ifndef SPH_TYPES_H
#define SPH_TYPES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <sph/error.h>
#include <sph/export.h>

/** Number of a particle or point in id order. */
typedef int32_t sph_index;

typedef struct sph_context sph_context;
typedef struct sph_kernel sph_kernel;
typedef struct sph_particles sph_particles;
typedef struct sph_search sph_search;
typedef struct sph_body sph_body;
typedef struct sph_solver sph_solver;
typedef struct sph_wall sph_wall;
typedef struct sph_interpolator sph_interpolator;
typedef struct sph_boundary sph_boundary;
typedef struct sph_integrator sph_integrator;
typedef struct sph_probe sph_probe;
typedef struct sph_output sph_output;
typedef struct sph_wave sph_wave;
typedef struct sph_paddle sph_paddle;

#endif
