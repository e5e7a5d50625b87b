/** @file
 * Status codes returned by every function that can fail.
 */
#ifndef SPH_ERROR_H
#define SPH_ERROR_H

#include <sph/export.h>

/** X(name, value, text). Zero is success.
 * Positive: the call changed nothing; correct the argument and try again.
 * Negative: the object the call worked on can only be read and destroyed.
 */
#define SPH_STATUS_LIST(X)                                                              \
  X(SPH_OK, 0, "success")                                                               \
  X(SPH_E_ARGUMENT, 1, "an argument is NULL, not finite, out of range or inconsistent") \
  X(SPH_E_STALE, 2, "the particles changed since this object was built")                \
  X(SPH_E_UNSUPPORTED, 3, "this combination is not implemented")                        \
  X(SPH_E_UNAVAILABLE, 4, "the library was built without this feature")                 \
  X(SPH_E_NOT_CONVERGED, 5, "an iteration reached its limit")                           \
  X(SPH_E_TYPE, 6, "the object is of another type than this call works on")             \
  X(SPH_E_NAME, 7, "no object, field or option has this name")                          \
  X(SPH_E_IO, 8, "a file could not be written or read")                                 \
  X(SPH_E_MEMORY, -1, "out of memory")                                                  \
  X(SPH_E_DIVERGED, -2, "the solution is not finite, or a particle left its domain")    \
  X(SPH_E_INTERNAL, -3, "an invariant of the library does not hold")

SPH_BEGIN_DECLS

/** Result of a call; see SPH_STATUS_LIST. */
typedef enum sph_status {
#define SPH_STATUS_ENUM(name, value, text) name = value,
  SPH_STATUS_LIST(SPH_STATUS_ENUM)
#undef SPH_STATUS_ENUM
} sph_status;

/** Name of a status code, for example "SPH_E_ARGUMENT"; "unknown" for any other number.
 *
 * Ownership  static text
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_status_name(sph_status status);

/** One line that says what a status code means.
 *
 * Ownership  static text
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_status_text(sph_status status);

SPH_END_DECLS

#endif
