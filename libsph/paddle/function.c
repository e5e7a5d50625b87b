/* A caller's function. */
#include "paddle/paddle_impl.h"

typedef struct function_data {
  sph_paddle_function function;
  void *user;
} function_data;

static void ask(const sph_paddle *paddle, double t, double *motion) {
  const function_data *data = paddle->data;
  motion[0] = motion[1] = motion[2] = 0;
  data->function(t, &motion[0], &motion[1], &motion[2], data->user);
}

static const sphi_paddle_law function_law = {
    .type = SPH_PADDLE_FUNCTION, .size = sizeof(function_data), .at = ask};

sph_status sph_paddle_create_function(sph_context *context, sph_paddle_function function,
                                      void *user, sph_paddle **out) {
  SPHI_PADDLE_BEGIN(context, function_law, out);
  SPH_CHECK(context, function, SPH_E_ARGUMENT, "paddle \"function\": function is NULL");
  SPH_TRY(sphi_paddle_new(context, &function_law, out));
  *(function_data *)(*out)->data = (function_data){function, user};
  (*out)->start = -INFINITY;
  (*out)->stroke = NAN;
  return SPH_OK;
}
