/* Moving least squares with the basis (1, X, Y, Z, XX, XY, XZ, YY, YZ, ZZ). */
#define OPERATOR mls_quadratic
#define ORDER 2
#include "interpolator/mls.inc.c"
