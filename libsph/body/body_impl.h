/* Bodies from the inside. */
#ifndef SPHI_BODY_IMPL_H
#define SPHI_BODY_IMPL_H

#include <sph/body.h>

#include "core/internal.h"

/* For the wall that it moves: one alone. */
sph_status sphi_body_take(sph_body *body, const sph_context *context, const char *wall);

#endif
