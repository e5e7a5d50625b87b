/* What studies of many runs share: a CSV with a row a run, which an interrupted study takes up again, and runs side
 * by side. */
#ifndef EXAMPLE_STUDY_H
#define EXAMPLE_STUDY_H

#include <stdio.h>

#include "example.h"

enum { STUDY_KEYS = 3, STUDY_FIGURES = 16, STUDY_LIST = 64 };

/* A run: what it was asked for, its figures (NaN: none), and its status with a message where it failed. */
typedef struct study_row {
  double keys[STUDY_KEYS], figures[STUDY_FIGURES];
  char status[32], message[EXAMPLE_MESSAGE];
} study_row;

typedef struct study_table {
  const char *path;
  const char *header; /* comments with all that figures depend on, then the names of the columns */
  int figures;
  FILE *file;
  study_row *rows;
  int count, room;
} study_table;

/* Numbers of a list "0.3,0.5" with nine digits, each from lowest to highest and none twice, or the end of the program. */
typedef struct study_list {
  int count;
  double values[STUDY_LIST];
} study_list;
study_list study_list_parse(const char *option, const char *text, double lowest, double highest);

/* Opens the CSV or makes it. A last row without its end is dropped, with `retry` failed ones too; a file with another
 * header or with lines that are no rows, or one that is in use, ends the program and stays as it is. */
void study_open(study_table *table, bool retry);
bool study_failed(const study_row *row);
const study_row *study_find(const study_table *table, const double *keys);
/* Adds a row, whole, to table and file. */
void study_add(study_table *table, const study_row *row);
/* Puts the rows of the file into the order of their keys. */
void study_close(study_table *table);

/* Computes `count` rows whose keys are given, `processors` at a time in threads of their own, and adds each when it is
 * done. compute(row, user) fills in status, message and figures, which are NaN before. Prints a line a run with the
 * time left. */
void study_run(study_table *table, int count, study_row *rows, int processors,
               void (*compute)(study_row *row, void *user), void *user);

#endif
