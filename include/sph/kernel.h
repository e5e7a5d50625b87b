/** @file
 * Smoothing kernels W(r, h) in 1D, 2D and 3D: built-in ones, or a caller's own functions.
 */
#ifndef SPH_KERNEL_H
#define SPH_KERNEL_H

#include <sph/types.h>

SPH_BEGIN_DECLS

/** Kinds of kernels; numbers 1 to sph_kernel_count() without gaps, never renumbered.
 *
 * With q = r/h each is W = sigma h^-dim f(q), normalised to integral 1, zero for r >= support.
 */
typedef enum sph_kernel_type {
  SPH_KERNEL_CUBIC_SPLINE = 1,   /**< cubic B-spline M4, support 2 h */
  SPH_KERNEL_QUINTIC_SPLINE = 2, /**< quintic B-spline M6, support 3 h */
  SPH_KERNEL_WENDLAND_C2 = 3, /**< Wendland polynomial C2, support 2 h; 1D has its own polynomial */
  SPH_KERNEL_WENDLAND_C4 = 4, /**< Wendland polynomial C4, support 2 h; 1D likewise */
  SPH_KERNEL_WENDLAND_C6 = 5, /**< Wendland polynomial C6, support 2 h; 1D likewise */
  SPH_KERNEL_GAUSSIAN = 6,    /**< renormalised Gaussian cut at 3 h */
  SPH_KERNEL_USER = 7         /**< the caller's functions, see sph_kernel_create_user() */
} sph_kernel_type;

/** A caller's function of q = r/h; it may be called for q in [0, ratio]. */
typedef double (*sph_kernel_function)(double q, void *user);

/** Create a built-in kernel.
 *
 *     W(r, h) = sigma h^-dim f(r/h)                                                (1)
 *     dW/dr   = sigma h^-(dim+1) f'(r/h)                                           (2)
 *
 * Units      dim 1, 2 or 3; h [m] > 0
 * Ownership  the caller destroys *out (NULL after an error); it holds a reference to the context
 * Parallel   not while another call uses the context; the kernel itself may then be read from
 *            several threads
 * Errors     SPH_E_ARGUMENT context or out NULL, unknown type or SPH_KERNEL_USER, dim not 1 to 3, h
 *            not finite, not > 0, or so small or large that W overflows; SPH_E_MEMORY
 * Source     the row of the kernel, see sph_kernel_source(); equations in docs/kernel.md
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_kernel_create(sph_context *context, sph_kernel_type type,
                                                   int dim, double h, sph_kernel **out);

/** Create a kernel from the caller's f(q) and f'(q); the normalisation is found by quadrature.
 *
 *     1/sigma = integral of f over the ball q < ratio                              (1)
 *
 * The functions are checked at 769 points: finite, w(0) in [1e-12, 1e12], w(ratio) at most 1e-3 of
 * w(0), dw(0) = 0, and dw equal to differences of w within 2e-3 of the largest |dw|. f must be
 * continuously differentiable. sph_kernel_w(), sph_kernel_dw() and sph_kernel_evaluate() call the
 * functions themselves; the sums over particles use piecewise cubics in q, 256 over the support.
 *
 * Units      dim 1, 2 or 3; h [m] > 0; ratio = support radius / h > 0
 * Ownership  the caller destroys *out (NULL after an error); it holds a reference to the context;
 *            user must live as long as the kernel
 * Parallel   as sph_kernel_create; w and dw must be thread-safe where the kernel is evaluated from
 *            several threads
 * Errors     SPH_E_ARGUMENT context, w, dw or out NULL, dim or h as for sph_kernel_create, ratio
 *            not finite or not > 0, a failed check of the functions, integral not > 0;
 *            SPH_E_UNAVAILABLE the library was built without GSL; SPH_E_MEMORY
 * Source     adaptive bisection with the 21-point Gauss-Kronrod rule of GSL; differs: none
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_kernel_create_user(sph_context *context, int dim, double h,
                                                        double ratio, sph_kernel_function w,
                                                        sph_kernel_function dw, void *user,
                                                        sph_kernel **out);

/** Release the caller's reference and set *kernel to NULL. NULL is allowed.
 *
 * Ownership  the memory goes when the last handle made from it is destroyed
 * Parallel   not while another call uses the kernel or its context
 * Errors     none
 * Since      0.1
 */
SPH_API void sph_kernel_destroy(sph_kernel **kernel);

/** The kind of kernel with this name; the message of a failure suggests the nearest one.
 *
 * Ownership  *type is untouched after an error
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT context, name or type NULL; SPH_E_NAME no such kernel
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_kernel_find(sph_context *context, const char *name,
                                                 sph_kernel_type *type);

/** Number of kinds of kernels: they are the numbers 1 to this one, for lists and menus.
 *
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API int sph_kernel_count(void);

/** Name of a kind, for example "wendland-c2"; "unknown" for any other number.
 *
 * Ownership  static text
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_kernel_name(sph_kernel_type type);

/** One line about a kind; "unknown" for any other number.
 *
 * Ownership  static text
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_kernel_summary(sph_kernel_type type);

/** The publication a kind is taken from; "unknown" for any other number.
 *
 * Ownership  static text
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_kernel_source(sph_kernel_type type);

/** Kind of a kernel; 0 if kernel is NULL.
 *
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API int sph_kernel_get_type(const sph_kernel *kernel);

/** Dimension of a kernel: 1, 2 or 3; 0 if kernel is NULL.
 *
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API int sph_kernel_get_dim(const sph_kernel *kernel);

/** Smoothing length h; NaN if kernel is NULL.
 *
 * Units      m
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API double sph_kernel_get_h(const sph_kernel *kernel);

/** Support radius, from which on W is zero; NaN if kernel is NULL.
 *
 * Units      m
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API double sph_kernel_get_support(const sph_kernel *kernel);

/** Normalisation sigma in W = sigma h^-dim f(q); NaN if kernel is NULL.
 *
 * Units      1
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API double sph_kernel_get_normalization(const sph_kernel *kernel);

/** W at the distance r, zero beyond the support.
 *
 * Units      r [m] >= 0; result m^-dim
 * Parallel   thread-safe
 * Errors     none: NaN if kernel is NULL, r is NaN or r < 0
 * Since      0.1
 */
SPH_API double sph_kernel_w(const sph_kernel *kernel, double r);

/** dW/dr at the distance r, zero beyond the support. grad_i W_ij = dW/dr (x_i - x_j) / r.
 *
 * Units      r [m] >= 0; result m^-(dim+1)
 * Parallel   thread-safe
 * Errors     none: NaN if kernel is NULL, r is NaN or r < 0
 * Since      0.1
 */
SPH_API double sph_kernel_dw(const sph_kernel *kernel, double r);

/** W and dW/dr at many distances, the same bits as sph_kernel_w() and sph_kernel_dw().
 *
 * Shape      r, w, dw [n]; w or dw may be NULL, and either may be the same array as r
 * Units      r [m] >= 0; w m^-dim; dw m^-(dim+1)
 * Ownership  borrows all arguments; nothing is written after an error
 * Parallel   not while another call uses the context of the kernel
 * Errors     SPH_E_ARGUMENT kernel NULL, n < 0, r NULL with n > 0, w and dw both NULL, a distance
 *            NaN or negative
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_kernel_evaluate(const sph_kernel *kernel, int64_t n,
                                                     const double *r, double *w, double *dw);

SPH_END_DECLS

#endif
