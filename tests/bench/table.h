/* What the benchmark prints while it measures. */
#ifndef TABLE_H
#define TABLE_H

#include "records.h"

/* For rows of one of schemes[]. */
void table_head(int number);
void table_row(const record *r);

#endif
