/* Bodies from the inside. */
#ifndef SPHI_BODY_IMPL_H
#define SPHI_BODY_IMPL_H

#include <sph/body.h>

#include "core/keep.h"

/* For the wall that it moves: one alone. */
sph_status sphi_body_take(sph_body *body, const sph_context *context, const char *wall);

/* About how much fluid moves with the body [kg]. An incompressible one takes the force of mass times acceleration
 * from it at once, and a body lighter than that would be thrown about by a force of the step before; with
 * (m + added) a = F + added a_before it follows, and for short steps m a = F is what is left. */
void sphi_body_add_mass(sph_body *body, double mass);

/* What a checkpoint keeps of it, in the section `name`. */
sph_status sphi_body_keep(sph_body *body, const char *name, sphi_keep *keep);

#endif
