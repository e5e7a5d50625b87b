/* Moving least squares with the basis (1, X, Y, Z). */
#define OPERATOR mls_linear
#define ORDER 1
#include "interpolator/mls.inc.c"
