/** @file
 * All of libsph: the one header that a program needs.
 */
#ifndef SPH_H
#define SPH_H

#include <sph/body.h>
#include <sph/boundary.h>
#include <sph/context.h>
#include <sph/error.h>
#include <sph/export.h>
#include <sph/flip.h>
#include <sph/initial.h>
#include <sph/integrator.h>
#include <sph/interpolator.h>
#include <sph/isph.h>
#include <sph/kernel.h>
#include <sph/mesh.h>
#include <sph/output.h>
#include <sph/paddle.h>
#include <sph/particles.h>
#include <sph/probe.h>
#include <sph/search.h>
#include <sph/solver.h>
#include <sph/types.h>
#include <sph/version.h>
#include <sph/wall.h>
#include <sph/wave.h>
#include <sph/wcsph.h>

#endif
