#include "records.h"

#include <math.h>
#include <sph/context.h>
#include <sph/version.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

static const struct {
  const char *key;
  size_t at;
} numbers[] = {
#define NUMBER(key) \
  { #key, offsetof(record, key) }
    NUMBER(threads),
    NUMBER(particles),
    NUMBER(ghosts),
    NUMBER(neighbours),
    NUMBER(ghost_neighbours),
    NUMBER(steps),
    NUMBER(evaluations_per_step),
    NUMBER(builds_per_step),
    NUMBER(step_ns),
    NUMBER(evaluation_ns),
    NUMBER(search_ns),
    NUMBER(pack_ns),
    NUMBER(boundary_ns),
    NUMBER(pairs_ns),
    NUMBER(update_ns),
    NUMBER(observers_ns),
    NUMBER(other_ns),
    NUMBER(build_ns),
    NUMBER(plain_list_ns),
    NUMBER(plain_pairs_ns),
    NUMBER(ratio_pairs),
    NUMBER(ratio_list),
    NUMBER(step_to_pairs),
    NUMBER(speed_up),
    NUMBER(pairs_per_second),
    NUMBER(flops),
    NUMBER(peak_gflops),
    NUMBER(peak_fraction),
    NUMBER(list_entries),
    NUMBER(bytes),
    NUMBER(bytes_peak),
    NUMBER(allocations_per_step),
    NUMBER(rows_ns),
    NUMBER(setup_ns),
    NUMBER(iterations_ns),
    NUMBER(iterations),
    NUMBER(delta_ns),
    NUMBER(solver_to_delta),
    NUMBER(step_to_delta),
#undef NUMBER
};
enum { NUMBERS = sizeof numbers / sizeof *numbers };

static double *number(record *r, int k) { return (double *)(void *)((char *)r + numbers[k].at); }

void records_machine(records *all) {
  snprintf(all->cpu, sizeof all->cpu, "unknown");
  FILE *file = fopen("/proc/cpuinfo", "r");
  if (!file) return;
  char line[256];
  while (fgets(line, sizeof line, file)) {
    const char *colon = strchr(line, ':');
    if (strncmp(line, "model name", 10) || !colon) continue;
    snprintf(all->cpu, sizeof all->cpu, "%.100s", colon + 2);
    all->cpu[strcspn(all->cpu, "\n\"\\")] = 0;
    break;
  }
  fclose(file);
}

double machine_load(void) {
  double load = -1;
  FILE *file = fopen("/proc/loadavg", "r");
  if (!file) return load;
  if (fscanf(file, "%lf", &load) != 1) load = -1;
  fclose(file);
  return load;
}

static void write_text(FILE *file, const char *text) {
  for (; *text; text++) {
    if (*text == '\n')
      fputs("; ", file);
    else if (*text == '"' || *text == '\\')
      fprintf(file, "\\%c", *text);
    else
      fputc(*text, file);
  }
}

bool records_write(const records *all, const char *path, double load_before, double load_after) {
  FILE *file = fopen(path, "w");
  if (!file) {
    perror(path);
    return false;
  }
  fprintf(file, "[\n{\"record\": \"machine\", \"cpu\": \"%s\", \"processors\": %d, ", all->cpu,
          sph_processor_count());
  fprintf(file, "\"load_before\": %.2f, \"load_after\": %.2f, \"build\": \"", load_before,
          load_after);
  write_text(file, sph_build_info());
  fputs("\"}", file);
  for (int k = 0; k < all->count; k++) {
    record r = all->entry[k];
    fprintf(file,
            ",\n{\"record\": \"flow\", \"case\": \"%s\", \"stepper\": \"%s\", \"isa\": \"%s\"",
            r.name, r.stepper, r.isa);
    for (int n = 0; n < NUMBERS; n++)
      fprintf(file, ", \"%s\": %.6g", numbers[n].key, *number(&r, n));
    fputs("}", file);
  }
  fputs("\n]\n", file);
  const bool bad = ferror(file) != 0;
  if (fclose(file) == 0 && !bad) return true;
  perror(path);
  return false;
}

/* What follows "key": in a line; NULL if it is not there. */
static const char *value_of(const char *line, const char *key) {
  char quoted[64];
  snprintf(quoted, sizeof quoted, "\"%s\": ", key);
  const char *found = strstr(line, quoted);
  return found ? found + strlen(quoted) : NULL;
}

static bool read_text(const char *line, const char *key, char *text, size_t room) {
  const char *value = value_of(line, key);
  if (!value || *value != '"') return false;
  const size_t length = strcspn(value + 1, "\"");
  if (length >= room) return false;
  memcpy(text, value + 1, length);
  text[length] = 0;
  return true;
}

static bool read_record(const char *line, record *r) {
  memset(r, 0, sizeof *r);
  if (!read_text(line, "case", r->name, sizeof r->name) ||
      !read_text(line, "stepper", r->stepper, sizeof r->stepper) ||
      !read_text(line, "isa", r->isa, sizeof r->isa))
    return false;
  for (int k = 0; k < NUMBERS; k++) {
    const char *value = value_of(line, numbers[k].key);
    *number(r, k) = value ? strtod(value, NULL) : NAN;
  }
  return r->step_ns > 0;
}

bool records_read(records *all, const char *path) {
  memset(all, 0, sizeof *all);
  FILE *file = fopen(path, "r");
  if (!file) {
    perror(path);
    return false;
  }
  char line[4096];
  bool machine = false;
  while (fgets(line, sizeof line, file)) {
    if (strstr(line, "\"record\": \"machine\""))
      machine = read_text(line, "cpu", all->cpu, sizeof all->cpu);
    if (strstr(line, "\"record\": \"flow\"") && all->count < RECORDS_MOST &&
        read_record(line, &all->entry[all->count]))
      all->count++;
  }
  fclose(file);
  if (machine && all->count > 0) return true;
  fprintf(stderr, "%s: not a file of this benchmark\n", path);
  return false;
}

static const record *find(const records *all, const record *like) {
  for (int k = 0; k < all->count; k++) {
    const record *r = &all->entry[k];
    if (!strcmp(r->name, like->name) && !strcmp(r->stepper, like->stepper) &&
        !strcmp(r->isa, like->isa) && r->threads == like->threads &&
        r->particles == like->particles)
      return r;
  }
  return NULL;
}

/* Ratio new/old of a step in terms of the plain loop; NaN if one has none, or one that knew no ghosts
 * where the other's did. */
static double ratio_by_plain(const record *old, const record *now) {
  const bool same = isfinite(old->ghost_neighbours) == isfinite(now->ghost_neighbours);
  if (!same || !(old->plain_pairs_ns > 0 && now->plain_pairs_ns > 0)) return NAN;
  return now->step_ns / old->step_ns * (old->plain_pairs_ns / now->plain_pairs_ns);
}

/* Prints one line; true if the step became slower by more than the limit. */
static bool compare(const record *old, const record *now, double limit) {
  const double clock = now->step_ns / old->step_ns, plain = ratio_by_plain(old, now);
  const bool slower = clock > 1 + limit && !(plain <= 1 + limit);
  char text[16] = "-";
  if (isfinite(plain)) snprintf(text, sizeof text, "%.3f", plain);
  printf("%-15s %-10s %-8s %3.0f %9.1f %9.1f %7.3f %9s%s\n", now->name, now->stepper, now->isa,
         now->threads, old->step_ns, now->step_ns, clock, text, slower ? "  SLOWER" : "");
  return slower;
}

bool records_compare(const records *old, const records *now, double limit) {
  if (strcmp(old->cpu, now->cpu)) {
    fprintf(stderr, "the stored run is from another machine: \"%s\", this one is \"%s\"\n",
            old->cpu, now->cpu);
    return false;
  }
  int common = 0, slower = 0;
  printf("%-15s %-10s %-8s %3s %9s %9s %7s %9s\n", "case", "stepper", "isa", "thr", "old step",
         "new step", "ratio", "by plain");
  for (int k = 0; k < now->count; k++) {
    const record *before = find(old, &now->entry[k]);
    if (!before) continue;
    common++;
    slower += compare(before, &now->entry[k], limit);
  }
  printf("%d compared, %d slower by more than %.0f %%\n", common, slower, 100 * limit);
  if (common == 0) fprintf(stderr, "the two runs have no measurement in common\n");
  return common > 0 && slower == 0;
}
