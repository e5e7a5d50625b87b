/* What one run of the benchmark found: kept as flat records, one a line of a JSON file, and compared
 * with those of another run. */
#ifndef RECORDS_H
#define RECORDS_H

#include <stdbool.h>
#include <stdio.h>

enum { RECORDS_MOST = 256 };

/* One flow with one scheme, instruction set and number of threads. Times are nanoseconds a particle
 * and force evaluation, step_ns a particle and step. NaN: a file that was read does not have it. */
typedef struct record {
  char name[32], stepper[16], isa[16];
  double threads, particles, ghosts;
  double neighbours, ghost_neighbours; /* a particle, within the support */
  double steps, evaluations_per_step, builds_per_step;
  double step_ns, evaluation_ns;
  double search_ns, pack_ns, boundary_ns, pairs_ns, update_ns, observers_ns, other_ns;
  double build_ns;                      /* a particle and list build */
  double plain_list_ns, plain_pairs_ns; /* the plain loop: a list, and the same sums */
  double ratio_pairs;                   /* plain_pairs_ns / pairs_ns */
  double ratio_list;                    /* the same with lists on both sides, built equally often */
  double step_to_pairs;                 /* evaluation_ns / pairs_ns */
  double speed_up;                      /* over one thread; 0 if one thread was not measured */
  double pairs_per_second;              /* neighbours, ghosts included, of an evaluation */
  double flops;                         /* operations of the sums a particle and evaluation */
  double peak_gflops, peak_fraction;    /* what the threads could do, and how much of it they do */
  double list_entries, bytes, bytes_peak, allocations_per_step;
  /* Incompressible SPH alone, 0 elsewhere. */
  double rows_ns, setup_ns, iterations_ns; /* pressure equation: rows; solver: set-up, iterations */
  double iterations;                       /* of the solver, a step */
  double delta_ns;                         /* an evaluation of weakly compressible SPH, no probes */
  double solver_to_delta, step_to_delta;   /* pressure equation, whole step by delta_ns */
} record;

typedef struct records {
  char cpu[128];
  int count;
  record entry[RECORDS_MOST];
} records;

void records_machine(records *all);

/* Writes the file, machine and build included; says why not on stderr. */
bool records_write(const records *all, const char *path, double load_before, double load_after);

/* Reads a file that records_write wrote; says why not on stderr. */
bool records_read(records *all, const char *path);

/* Prints the ratios new/old of all that both have. False if the machines differ, if they have nothing
 * in common, or if a step became slower by more than `limit` (0.1: a tenth), both by the clock and
 * measured by the plain loop of the same run; by the clock alone where the two files' plain loops did
 * not do the same. */
bool records_compare(const records *old, const records *now, double limit);

double machine_load(void);

#endif
