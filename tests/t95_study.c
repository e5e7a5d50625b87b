/* The parameter study of the seawall, as a program: what it leaves when it is stopped, fed with other files, or fails. */
#define _POSIX_C_SOURCE 200809L
#include <ctype.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "sph_test.h"

enum { TEXT = 1 << 16 };
static char folder[] = "/tmp/sph_t95_XXXXXX";

/* Runs an example in the folder; returns its exit status, its words in `said`. */
static char said[TEXT];
static int run(const char *program, const char *options) {
  char command[2048];
  snprintf(command, sizeof command, "cd %s && '%s/%s' %s >said 2>&1", folder, EXAMPLES, program,
           options);
  const int status = system(command);
  snprintf(command, sizeof command, "%s/said", folder);
  FILE *file = fopen(command, "r");
  CU_ASSERT_FATAL(file != NULL);
  said[fread(said, 1, TEXT - 1, file)] = '\0';
  fclose(file);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static void read_file(const char *name, char *text) {
  char path[256];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  FILE *file = fopen(path, "r");
  text[file ? fread(text, 1, TEXT - 1, file) : 0] = '\0';
  if (file) fclose(file);
}

static void write_file(const char *name, const char *mode, const char *text) {
  char path[256];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  FILE *file = fopen(path, mode);
  CU_ASSERT_FATAL(file != NULL);
  fputs(text, file);
  fclose(file);
}

/* The columns of study.csv, of each row. */
enum { H, K, M, FORCE, FORCE_TIME, RUN_UP, RUN_UP_TIME, ONSET, X_MAX, X_TIME, X_END, LOST, STEPS };
enum { SECONDS = STEPS + 1, COLUMNS };
typedef struct rows {
  int count;
  double values[32][COLUMNS];
} rows;
static rows read_rows(const char *name) {
  static char text[TEXT];
  rows all = {0};
  read_file(name, text);
  for (const char *line = text; *line != '\0'; line = strchr(line, '\n') + 1) {
    if (!isdigit((unsigned char)*line)) continue;
    CU_ASSERT_FATAL(all.count < 32);
    const char *at = line;
    for (int c = 0; c < COLUMNS; c++) {
      char *after = NULL;
      all.values[all.count][c] = strtod(at, &after);
      at = after + 1;
    }
    all.count++;
  }
  return all;
}

/* All but the seconds, which no two runs share. */
static bool same_rows(const rows *a, const rows *b) {
  if (a->count != b->count) return false;
  for (int n = 0; n < a->count; n++)
    for (int c = 0; c < SECONDS; c++)
      if (a->values[n][c] != b->values[n][c] && !(isnan(a->values[n][c]) && isnan(b->values[n][c])))
        return false;
  return true;
}

#define COARSE "--method wcsph --dx 0.04 --end-time 2.7 "
#define TWELVE COARSE "--heights 0.5,0.3 --stiffnesses 10,1e3,1e7 --masses 500,50 "

static void test_goes_on(void) {
  CU_ASSERT(run("seawall_study", TWELVE "--processors 2 --out whole.csv") == 0);
  CU_ASSERT(strstr(said, "seawall_study: 12 of 12 runs, 0 failed\n") != NULL);
  CU_ASSERT(run("seawall_study", TWELVE "--processors 1 --runs 5 --out study.csv") == 0);
  CU_ASSERT(strstr(said, "seawall_study: 5 of 12 runs, 0 failed\n") != NULL);
  CU_ASSERT(read_rows("study.csv").count == 5);
  write_file("study.csv", "a", "0.3,10,50,1.3770");
  CU_ASSERT(run("seawall_study", TWELVE "--processors 1 --out study.csv") == 0);
  CU_ASSERT(strstr(said, "\n7 of 7: ") != NULL);
  const rows whole = read_rows("whole.csv"), study = read_rows("study.csv");
  CU_ASSERT(study.count == 12);
  CU_ASSERT(same_rows(&study, &whole));
  for (int n = 1; n < study.count; n++) {
    const double *a = study.values[n - 1], *b = study.values[n];
    CU_ASSERT(a[H] < b[H] || (a[H] == b[H] && (a[K] < b[K] || (a[K] == b[K] && a[M] < b[M]))));
  }
}

/* Nothing is left to do, and other lists add rows to the same file. */
static void test_adds_rows(void) {
  static char before[TEXT], after[TEXT];
  read_file("study.csv", before);
  CU_ASSERT(run("seawall_study", TWELVE "--out study.csv") == 0);
  CU_ASSERT(strcmp(said, "seawall_study: 12 of 12 runs, 0 failed\n") == 0);
  read_file("study.csv", after);
  CU_ASSERT(*before != '\0' && strcmp(before, after) == 0);
  CU_ASSERT(run("seawall_study",
                COARSE "--heights 0.3 --stiffnesses 10 --masses 50,1e3 --out study.csv") == 0);
  CU_ASSERT(strstr(said, "seawall_study: 2 of 2 runs, 0 failed\n") != NULL);
  CU_ASSERT(read_rows("study.csv").count == 13);
}

/* Forces within 2 %: they are noisy at five particles a depth. */
static void test_response(void) {
  const rows all = read_rows("whole.csv");
  int pairs = 0;
  for (int a = 0; a < all.count; a++)
    for (int b = 0; b < all.count; b++) {
      const double *x = all.values[a], *y = all.values[b];
      const bool heavier = x[H] == y[H] && x[K] == y[K] && x[M] < y[M];
      const bool stiffer = x[H] == y[H] && x[K] < y[K] && x[M] == y[M];
      const bool higher = x[H] < y[H] && x[K] == y[K] && x[M] == y[M];
      if (!heavier && !stiffer && !higher) continue;
      SPH_TEST_BELOW(x[FORCE], 1.02 * y[FORCE]);
      SPH_TEST_BELOW(x[RUN_UP], 1.02 * y[RUN_UP]);
      if (stiffer) SPH_TEST_BELOW(y[X_MAX], x[X_MAX]);
      if (higher && !isnan(x[ONSET])) SPH_TEST_BELOW(y[ONSET], x[ONSET]);
      pairs++;
    }
  CU_ASSERT(pairs == 6 + 12 + 6);
  for (int n = 0; n < all.count; n++) CU_ASSERT(all.values[n][LOST] == 0);
}

static double figure(const char *summary, const char *key) {
  const char *at = strstr(summary, key);
  return at ? strtod(at + strlen(key) + 2, NULL) : NAN; /* "key": number */
}

static void test_is_movable_seawall(void) {
  static char summary[TEXT];
  CU_ASSERT(run("seawall_study",
                "--dx 0.04 --end-time 2.7 --heights 0.4 --stiffnesses 100 "
                "--masses 100 --out one.csv") == 0);
  CU_ASSERT(run("movable_seawall",
                "--method isph --dx 0.04 --end 2.7 --height-ratio 0.4 --stiffness 100 --mass 100 "
                "--paddle-middle 1 --threads 1 --summary one.json") == 0);
  read_file("one.json", summary);
  const rows one = read_rows("one.csv");
  CU_ASSERT_FATAL(one.count == 1);
  const double *row = one.values[0];
  CU_ASSERT(row[FORCE] == figure(summary, "force_max_over_static"));
  CU_ASSERT(row[FORCE_TIME] == figure(summary, "force_max_time_s"));
  CU_ASSERT(row[RUN_UP] == figure(summary, "run_up_over_d"));
  CU_ASSERT(row[RUN_UP_TIME] == figure(summary, "run_up_time_s"));
  CU_ASSERT(row[ONSET] == figure(summary, "moves_from_s"));
  CU_ASSERT(row[X_MAX] == figure(summary, "displacement_max_over_d"));
  CU_ASSERT(row[X_END] == figure(summary, "displacement_end_over_d"));
  CU_ASSERT(row[STEPS] == figure(summary, "\"steps"));
}

/* No wave is higher than 0.8332 depths by this theory: such a run fails, and the others are there. */
#define FAILS \
  "--method wcsph --theory fenton --dx 0.05 --end-time 0.5 --stiffnesses 10 --masses 50 "

static void test_failed_run(void) {
  static char text[TEXT];
  CU_ASSERT(run("seawall_study", FAILS "--heights 0.9,0.3 --out failed.csv") == 1);
  CU_ASSERT(strstr(said, "seawall_study: 2 of 2 runs, 1 failed\n") != NULL);
  read_file("failed.csv", text);
  CU_ASSERT(strstr(text, "\n0.3,10,50,") != NULL && strstr(text, ",SPH_OK,\"\"\n") != NULL);
  CU_ASSERT(strstr(text, "\n0.9,10,50,nan,nan,") != NULL);
  CU_ASSERT(strstr(text, ",SPH_E_ARGUMENT,\"wave 'fenton': H/d must be at most 0.8332") != NULL);
  CU_ASSERT(run("seawall_study", FAILS "--heights 0.9,0.3 --out failed.csv") == 1);
  CU_ASSERT(strcmp(said, "seawall_study: 2 of 2 runs, 1 failed\n") == 0);
  CU_ASSERT(run("seawall_study", FAILS "--heights 0.9,0.3 --retry --out failed.csv") == 1);
  CU_ASSERT(strstr(said, "1 of 1: 0.9, ") != NULL);
  CU_ASSERT(read_rows("failed.csv").count == 2);
}

/* bad.csv holds `text`: the study refuses it with status 2 and words, and leaves it. */
static void refused(const char *text, const char *words) {
  static char after[TEXT];
  write_file("bad.csv", "w", text);
  CU_ASSERT(run("seawall_study", FAILS "--heights 0.3 --out bad.csv") == 2);
  if (!strstr(said, words)) printf("\n\"%s\" is not in: %s", words, said);
  CU_ASSERT(strstr(said, words) != NULL);
  read_file("bad.csv", after);
  CU_ASSERT(strcmp(text, after) == 0);
}

static void test_other_files(void) {
  static char good[TEXT], text[2 * TEXT];
  CU_ASSERT(run("seawall_study", FAILS "--heights 0.3 --out good.csv") == 0);
  read_file("good.csv", good);
  const char *row = strstr(good, "\n0.3,");
  CU_ASSERT_FATAL(row != NULL);
  refused("#!/bin/sh\necho mine\n", "is not of this study: it has \"#!/bin/sh\"");
  snprintf(text, sizeof text, "%s", good);
  memcpy(strstr(text, "dx=0.05"), "dx=0.04", 7);
  refused(text, "dx=0.04");
  static const char *const bad[] = {"0.3,10\n",
                                    "not a number\n",
                                    "\n",
                                    "nan,10,50,1,1,1,1,1,1,1,1,1,1,1,SPH_OK,\"\"\n",
                                    "0.4,10,50,1,1,1,1,1,1,1,1,1,1,1,SPH_OK,\"\n",
                                    "0.4,10,50,1,1,1,1,1,1,1,1,1,1,1,,\"\"\n",
                                    "0.4,10,50,1,1,1,1,1,1,1,1,1,1,1,SPH_OK,\"\",1\n",
                                    "0.4,10,50,1,1,1,1,1,1,1,1,1,1,1,%n%s,\"\"\n"};
  for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
    snprintf(text, sizeof text, "%s%s%s", good, bad[k], row + 1);
    refused(text, "line 6 is no row of a study");
  }
  snprintf(text, sizeof text, "%s%s", good, row + 1);
  refused(text, "line 6 has a run for the second time");
  const size_t length = strlen(good);
  memcpy(text, good, length);
  memset(text + length, '7', 5000);
  snprintf(text + length + 5000, 2, "\n");
  refused(text, "line 6 is no row of a study");
  /* A row that no line feed ends, however long it is, was cut off. */
  text[length + 1000] = '\0';
  write_file("torn.csv", "w", text);
  CU_ASSERT(run("seawall_study", FAILS "--heights 0.3 --out torn.csv") == 0);
  read_file("torn.csv", text);
  CU_ASSERT(strcmp(text, good) == 0);
  /* So was a header: nothing is lost by starting again. */
  text[100] = '\0';
  write_file("torn.csv", "w", text);
  CU_ASSERT(run("seawall_study", FAILS "--heights 0.3 --out torn.csv") == 0);
  CU_ASSERT(read_rows("torn.csv").count == 1);
}

static void test_cannot_write(void) {
  char path[256];
  CU_ASSERT(run("seawall_study", FAILS "--heights 0.3 --out missing/study.csv") == 2);
  CU_ASSERT(strstr(said, "missing/study.csv: No such file or directory") != NULL);
  CU_ASSERT(run("seawall_study", FAILS "--heights 0.3 --out .") == 2);
  CU_ASSERT(strstr(said, ". is no plain file") != NULL);
  CU_ASSERT(run("seawall_study", FAILS "--heights 0.3 --out /dev/full") == 2);
  CU_ASSERT(strstr(said, "/dev/full is no plain file") != NULL);
  /* Another study, here this test, has the file. */
  snprintf(path, sizeof path, "%s/good.csv", folder);
  const int held = open(path, O_RDWR);
  struct flock whole = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
  CU_ASSERT_FATAL(held >= 0 && fcntl(held, F_SETLK, &whole) == 0);
  CU_ASSERT(run("seawall_study", FAILS "--heights 0.4 --out good.csv") == 2);
  CU_ASSERT(strstr(said, "good.csv is in use by another study") != NULL);
  close(held);
  /* What is put in the file's place has nowhere to go. */
  snprintf(path, sizeof path, "%s/good.csv.new", folder);
  CU_ASSERT(mkdir(path, 0777) == 0);
  CU_ASSERT(run("seawall_study", FAILS "--heights 0.3 --out good.csv") == 2);
  CU_ASSERT(strstr(said, "good.csv.new: Is a directory") != NULL);
  CU_ASSERT(read_rows("good.csv").count == 1);
}

static void test_options(void) {
  static const struct {
    const char *options, *words;
  } cases[] = {{"--heights 0.3,,0.4", "\"0.3,,0.4\" is no list of numbers"},
               {"--heights 0.3,", "is no list of numbers"},
               {"--masses 50,0", "must be 1e-06 to 1e+09, got 0"},
               {"--masses nan", "must be 1e-06 to 1e+09, got nan"},
               {"--stiffnesses 5,6,5", "has 5 twice"},
               {"--threads 2", "a run of the study has one"},
               {"--method sph", "\"sph\" is neither wcsph nor isph"}};
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
    CU_ASSERT(run("seawall_study", cases[k].options) == 2);
    if (!strstr(said, cases[k].words)) printf("\n\"%s\" is not in: %s", cases[k].words, said);
    CU_ASSERT(strstr(said, cases[k].words) != NULL);
  }
}

static void test_folder_goes(void) {
  char command[256];
  snprintf(command, sizeof command, "rm -rf '%s'", folder);
  CU_ASSERT(system(command) == 0);
}

int main(void) {
  const sph_test tests[] = {
      {"a study that was stopped, with a torn row, ends as one that was not, on one or two "
       "processors",
       test_goes_on},
      {"a finished study stays as it is; other lists add rows", test_adds_rows},
      {"heavier and stiffer walls and higher waves: larger force and run-up", test_response},
      {"a run of the study is that of movable_seawall", test_is_movable_seawall},
      {"a run that fails is a row that says so, and is done again when asked for", test_failed_run},
      {"files of other settings, lines that are no rows, double rows are refused and kept",
       test_other_files},
      {"files that cannot be written are refused before any run", test_cannot_write},
      {"bad lists and settings are refused", test_options},
      {"nothing is left behind", test_folder_goes}};
  if (!mkdtemp(folder)) return 2;
  return sph_test_main("study", (int)(sizeof tests / sizeof tests[0]), tests);
}
