/* What the benchmark prints while it measures. */
#ifndef TABLE_H
#define TABLE_H

#include "records.h"

void table_head(void);
void table_row(const record *r);

#endif
