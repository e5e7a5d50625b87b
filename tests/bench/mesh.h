/* Measures particles with a mesh: no plain loop stands beside them. */
#ifndef BENCH_MESH_H
#define BENCH_MESH_H

#include "measure.h"

/* Prints as it goes; ends the program if something fails. */
void measure_mesh(const flow_case *of, const selection *what, records *all);

#endif
