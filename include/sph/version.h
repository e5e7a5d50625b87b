/** @file
 * The version of the library: the one place where it is written.
 */
#ifndef SPH_VERSION_H
#define SPH_VERSION_H

#include <sph/export.h>

#define SPH_VERSION_MAJOR 0
#define SPH_VERSION_MINOR 1
#define SPH_VERSION_PATCH 0

/** True when the headers are at least version a.b.c. */
#define SPH_VERSION_GE(a, b, c)                                                        \
  (SPH_VERSION_MAJOR > (a) || (SPH_VERSION_MAJOR == (a) && SPH_VERSION_MINOR > (b)) || \
   (SPH_VERSION_MAJOR == (a) && SPH_VERSION_MINOR == (b) && SPH_VERSION_PATCH >= (c)))

SPH_BEGIN_DECLS

/** Version of the library that is linked, as "major.minor.patch".
 *
 * Ownership  static text, never freed
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_version(void);

/** How the library was built: compiler, options, optional libraries, instruction sets.
 *
 * Ownership  static text of several lines "name value", never freed
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_build_info(void);

SPH_END_DECLS

#endif
