/* How long a step of SPH takes, phase by phase: weakly compressible against a plain loop over the same
 * particles in the same run, incompressible against weakly compressible. See README.md in this folder, and docs/performance.md. */
#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "measure.h"
#include "records.h"
#include "world.h"

typedef struct options {
  selection what;
  const char *cases, *json, *compare, *from;
} options;

static void usage(FILE *to) {
  fputs(
      "usage: bench [--quick] [--cases NAME,...] [--isa NAME] [--threads N] [--scheme NAME]\n"
      "             [--preconditioner NAME] [--repeats 1..9] [--json FILE]\n"
      "             [--compare OLD.json [--from NEW.json]]\n"
      "  --quick    fewer particles and repeats: seconds, for a first look\n"
      "  --cases    which flows, or \"all\"; one of:",
      to);
  for (int k = 0; k < flow_case_count; k++)
    fprintf(to, " %s%s", flow_cases[k].name, flow_cases[k].usual ? "" : " (not by default)");
  fputs("\n  --isa      this instruction set alone:", to);
  for (sph_isa isa = SPH_ISA_BASELINE; isa <= SPH_ISA_AVX512; isa++)
    fprintf(to, " %s", sph_isa_name(isa));
  fputs(
      "\n  --threads  this number alone, instead of one and all processors\n"
      "  --scheme   this scheme alone:",
      to);
  for (int k = 0; k < SCHEMES; k++) fprintf(to, " %s", schemes[k].name);
  fputs("\n  --preconditioner  of incompressible SPH, instead of the library's choice:", to);
  for (int k = 1; k <= sph_preconditioner_count(); k++)
    fprintf(to, " %s", sph_preconditioner_name((sph_preconditioner)k));
  fputs(
      "\n  --repeats  measurements that each median is taken of (5, with --quick 3)\n"
      "  --json     write what was measured to a file\n"
      "  --compare  compare with a file of this machine; status 1 if a step is 10 % slower\n"
      "  --from     compare this file instead of measuring\n",
      to);
}

static _Noreturn void refuse(const char *option, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
static _Noreturn void refuse(const char *option, const char *format, ...) {
  va_list list;
  va_start(list, format);
  fprintf(stderr, "bench: %s: ", option);
  vfprintf(stderr, format, list);
  fputs("; --help lists the options\n", stderr);
  va_end(list);
  exit(2);
}

static int integer(const char *option, const char *text, int most) {
  char *end;
  const long value = strtol(text, &end, 10);
  if (!isdigit((unsigned char)*text) || *end || value < 1 || value > most)
    refuse(option, "must be 1 to %d, got \"%s\"", most, text);
  return (int)value;
}

static sph_isa instruction_set(const char *option, const char *name) {
  for (sph_isa isa = SPH_ISA_BASELINE; isa <= SPH_ISA_AVX512; isa++) {
    if (strcmp(name, sph_isa_name(isa))) continue;
    if (!isa_is_available(isa)) refuse(option, "this processor or build has no \"%s\"", name);
    return isa;
  }
  refuse(option, "\"%s\" is no instruction set", name);
}

static int scheme_number(const char *option, const char *name) {
  for (int k = 0; k < SCHEMES; k++)
    if (!strcmp(name, schemes[k].name)) return k;
  refuse(option, "\"%s\" is no scheme that is measured", name);
}

static int preconditioner_number(const char *option, const char *name) {
  for (int k = 1; k <= sph_preconditioner_count(); k++)
    if (!strcmp(name, sph_preconditioner_name((sph_preconditioner)k))) return k;
  refuse(option, "\"%s\" is no preconditioner", name);
}

/* The first name of a comma-separated list is this one. */
static bool begins_with(const char *list, const char *name) {
  const size_t length = strcspn(list, ",");
  return length == strlen(name) && !strncmp(list, name, length);
}

static const char *next_name(const char *list) {
  const char *comma = strchr(list, ',');
  return comma ? comma + 1 : NULL;
}

static bool is_listed(const char *list, const char *name) {
  for (const char *at = list; at; at = next_name(at))
    if (begins_with(at, name)) return true;
  return false;
}

static bool is_chosen(const options *o, int k) {
  if (!o->cases) return flow_cases[k].usual;
  return !strcmp(o->cases, "all") || is_listed(o->cases, flow_cases[k].name);
}

static void check_cases(const char *option, const char *list) {
  if (!strcmp(list, "all")) return;
  for (const char *at = list; at; at = next_name(at)) {
    bool known = false;
    for (int k = 0; k < flow_case_count; k++) known |= begins_with(at, flow_cases[k].name);
    if (!known) refuse(option, "\"%.*s\" is no flow", (int)strcspn(at, ","), at);
  }
}

static void set_option(options *o, const char *option, const char *value) {
  if (!strcmp(option, "--cases"))
    check_cases(option, o->cases = value);
  else if (!strcmp(option, "--isa"))
    o->what.isa = instruction_set(option, value);
  else if (!strcmp(option, "--threads"))
    o->what.threads = integer(option, value, sph_processor_count());
  else if (!strcmp(option, "--scheme"))
    o->what.scheme = scheme_number(option, value);
  else if (!strcmp(option, "--preconditioner"))
    o->what.preconditioner = preconditioner_number(option, value);
  else if (!strcmp(option, "--repeats"))
    o->what.repeats = integer(option, value, REPEATS_MOST);
  else if (!strcmp(option, "--json"))
    o->json = value;
  else if (!strcmp(option, "--compare"))
    o->compare = value;
  else if (!strcmp(option, "--from"))
    o->from = value;
  else
    refuse(option, "is no option");
}

static void parse(int argc, char **argv, options *o) {
  for (int k = 1; k < argc; k++) {
    const char *option = argv[k];
    if (!strcmp(option, "--help")) {
      usage(stdout);
      exit(0);
    }
    if (!strcmp(option, "--quick")) {
      o->what.quick = true;
      continue;
    }
    if (k + 1 == argc) refuse(option, "is no option, or its value is missing");
    set_option(o, option, argv[++k]);
  }
  if (o->what.repeats == 0) o->what.repeats = o->what.quick ? 3 : 5;
  if (o->from && !o->compare) refuse("--from", "needs --compare");
}

static bool measure(const options *o, records *now) {
  records_machine(now);
  const double begin = clock_now(), load = machine_load();
  printf("%s, %d processors, load %.2f\n%s", now->cpu, sph_processor_count(), load,
         sph_build_info());
  for (int k = 0; k < flow_case_count; k++)
    if (is_chosen(o, k)) measure_case(&flow_cases[k], &o->what, now);
  printf("\nmeasured in %.0f s, load now %.2f\n", clock_now() - begin, machine_load());
  if (!o->json) return true;
  if (!records_write(now, o->json, load, machine_load())) return false;
  printf("wrote %s\n", o->json);
  return true;
}

int main(int argc, char **argv) {
  static records old, now;
  options o = {.what = {.scheme = -1}};
  parse(argc, argv, &o);
  if (o.compare && !records_read(&old, o.compare)) return 2;
  if (o.from ? !records_read(&now, o.from) : !measure(&o, &now)) return 2;
  if (o.compare && !records_compare(&old, &now, 0.1)) return 1;
  return 0;
}
