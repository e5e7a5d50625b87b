/* Measures flows, phase by phase, against the plain loop over the same particles in the same run. */
#ifndef MEASURE_H
#define MEASURE_H

#include "records.h"
#include "world.h"

enum { REPEATS_MOST = 9 };

/* What is measured of a flow. */
typedef struct selection {
  bool quick;         /* twice the spacing, fewer steps before */
  int repeats;        /* 1 to REPEATS_MOST: each figure is their median */
  sph_isa isa;        /* SPH_ISA_AUTO: all that the processor has */
  int threads;        /* 0: one, and all processors */
  int scheme;         /* of schemes[], or -1: all */
  int preconditioner; /* of incompressible SPH; 0: the library's choice */
} selection;

bool isa_is_available(sph_isa isa);

double median(const double *values, int count);

/* Prints as it goes; ends the program if something fails, or if the plain loop and the library do not
 * compute the same. */
void measure_case(const flow_case *of, const selection *what, records *all);

#endif
