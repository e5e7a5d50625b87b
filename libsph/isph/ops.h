/* Arguments of the operators of incompressible SPH. Arrays are in storage order; those that are `void *`
 * have the reals of the variant, and room for SPHI_PAD more. */
#ifndef SPHI_ISPH_OPS_H
#define SPHI_ISPH_OPS_H

#include "integrator/integrator_impl.h"

/* op_projection */
typedef struct sphi_projection_arguments {
  void *filling;   /* [n] C */
  void *shear[9];  /* [n] T, a row of dim for each component of the velocity */
  void *normal[3]; /* [n] N */
  void *walls[3];  /* [n] what of it is of ghosts: towards walls */
  void *moment[6]; /* [n] M: xx yy xy | xx yy zz xy xz yz */
} sphi_projection_arguments;

/* op_laplacian */
typedef struct sphi_laplacian_arguments {
  const void *scale, *q[3]; /* [n] */
  const int64_t *place[2];  /* [n] of the first particle of a cluster: where its entries start */
  void *entry[2];           /* of fluid and of ghosts */
  void *sum, *count;        /* [n] of entries of fluid that are not 0 */
  void *up[3];              /* [n] towards open neighbours */
  void *collision[3];       /* [n] B */
  double spacing;
} sphi_laplacian_arguments;

/* op_viscosity */
typedef struct sphi_viscosity_arguments {
  void *acceleration[3]; /* [n] */
  double nu;
} sphi_viscosity_arguments;

#endif
