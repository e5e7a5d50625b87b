/* The kernels: one row and one include for each, and the formulas themselves in its own header.
 *
 * X(id, ENUMERATOR, stem, "name", support radius / h, "summary", "source"). The id is ABI: rows are
 * added at the end, never removed or renumbered, and include/sph/kernel.h has the same enumerators.
 * A header <stem>.h defines
 *   double sphi_<stem>_sigma(int dim)                       the normalisation
 *   vreal sphi_<stem>_f(vreal q2, int dim, lanes)           f(q), q2 = (r/h)^2
 *   double sphi_<stem>_slope(int dim)                       a constant factor of f'
 *   vreal sphi_<stem>_g(vreal q2, int dim, lanes)           f'(q)/q without it, finite at q = 0
 * f and g are exactly zero for q >= support radius / h, and dim is a literal at every call.
 * With SPHI_KERNEL_ROWS_ONLY defined, this file gives the rows without the formulas.
 */
#ifndef SPHI_KERNEL_LIST_H
#define SPHI_KERNEL_LIST_H

#define SPHI_KERNEL_LIST(X)                                                                       \
  X(1, CUBIC_SPLINE, cubic_spline, "cubic-spline", 2.0, "cubic B-spline M4, support 2 h",         \
    "Monaghan and Lattanzio (1985)")                                                              \
  X(2, QUINTIC_SPLINE, quintic_spline, "quintic-spline", 3.0, "quintic B-spline M6, support 3 h", \
    "Morris, Fox and Zhu (1997)")                                                                 \
  X(3, WENDLAND_C2, wendland_c2, "wendland-c2", 2.0, "Wendland polynomial C2, support 2 h",       \
    "Wendland (1995); Dehnen and Aly (2012), table 1")                                            \
  X(4, WENDLAND_C4, wendland_c4, "wendland-c4", 2.0, "Wendland polynomial C4, support 2 h",       \
    "Wendland (1995); Dehnen and Aly (2012), table 1")                                            \
  X(5, WENDLAND_C6, wendland_c6, "wendland-c6", 2.0, "Wendland polynomial C6, support 2 h",       \
    "Wendland (1995); Dehnen and Aly (2012), table 1")                                            \
  X(6, GAUSSIAN, gaussian, "gaussian", 3.0, "renormalised Gaussian cut at 3 h",                   \
    "Huang et al. (2019), eq. (7)")                                                               \
  X(7, USER, user, "user", 0.0, "the caller's functions, see sph_kernel_create_user", "the caller")

#endif

#if !defined(SPHI_KERNEL_ROWS_ONLY) && !defined(SPHI_KERNEL_FORMULAS)
#define SPHI_KERNEL_FORMULAS

#include "kernel/cubic_spline.h"
#include "kernel/gaussian.h"
#include "kernel/quintic_spline.h"
#include "kernel/user.h"
#include "kernel/wendland_c2.h"
#include "kernel/wendland_c4.h"
#include "kernel/wendland_c6.h"

#endif
