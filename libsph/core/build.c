/* What was built, and how: the Makefile hands the facts to this file alone. */

#include <sph/version.h>

#define TEXT_(x) #x
#define TEXT(x) TEXT_(x)

#ifndef SPHI_BUILD_OPT
#define SPHI_BUILD_OPT "unknown"
#define SPHI_BUILD_OP_OPT "unknown"
#define SPHI_BUILD_VARIANTS "unknown"
#define SPHI_BUILD_SAN "unknown"
#define SPHI_BUILD_PETSC "unknown"
#endif

#if defined(__clang__)
#define COMPILER __VERSION__
#elif defined(__GNUC__)
#define COMPILER "gcc " __VERSION__
#else
#define COMPILER "unknown"
#endif

#ifdef SPHI_GSL
#include <gsl/gsl_version.h>
#define GSL_TEXT GSL_VERSION
#else
#define GSL_TEXT "no"
#endif

#ifdef _OPENMP
#define OPENMP_TEXT TEXT(_OPENMP)
#else
#define OPENMP_TEXT "no"
#endif

#define VERSION_TEXT TEXT(SPH_VERSION_MAJOR) "." TEXT(SPH_VERSION_MINOR) "." TEXT(SPH_VERSION_PATCH)

const char *sph_version(void) { return VERSION_TEXT; }

const char *sph_build_info(void) {
  return "version " VERSION_TEXT "\ncompiler " COMPILER "\noptimisation " SPHI_BUILD_OPT
         "\npair-loop-optimisation " SPHI_BUILD_OP_OPT "\npair-loop-variants " SPHI_BUILD_VARIANTS
         "\nsanitizers " SPHI_BUILD_SAN "\ngsl " GSL_TEXT "\npetsc " SPHI_BUILD_PETSC
         "\nopenmp " OPENMP_TEXT "\n";
}
