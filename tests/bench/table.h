/* What the benchmark prints while it measures. */
#ifndef TABLE_H
#define TABLE_H

#include "records.h"

void table_head(bool incompressible);
void table_row(const record *r);

#endif
