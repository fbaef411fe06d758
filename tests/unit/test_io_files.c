/* The plain files of a run: tables, log, progress, timings, series, run directory. */
#include "base/memory.h"
#include "comm/comm.h"
#include "io/json.h"
#include "io/log.h"
#include "io/progress.h"
#include "io/run_dir.h"
#include "io/series.h"
#include "io/tables.h"
#include "io/text.h"
#include "io/timings.h"

#include <check.h>
#include <errno.h>
#include <ftw.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static hc_comm comm;
static char directory[64];
static hc_error error;

static int remove_one(const char *path, const struct stat *facts, int type, struct FTW *where) {
  (void)facts, (void)type, (void)where;
  return remove(path);
}
static void setup(void) {
  strcpy(directory, "/tmp/halocline_io_XXXXXX");
  ck_assert_ptr_nonnull(mkdtemp(directory));
}
static void teardown(void) {
  nftw(directory, remove_one, 16, FTW_DEPTH | FTW_PHYS);
}

static const char *in(const char *name) {
  static char path[4][256];
  static int turn = 0;
  turn = (turn + 1) % 4;
  snprintf(path[turn], sizeof *path, "%s/%s", directory, name);
  return path[turn];
}

/* The whole file; valid until the next call. */
static const char *content(const char *name) {
  static char text[65536];
  FILE *file = fopen(in(name), "r");
  ck_assert_msg(file != NULL, "no file %s", name);
  text[fread(text, 1, sizeof text - 1, file)] = 0;
  fclose(file);
  return text;
}

static void touch(const char *name) {
  FILE *file = fopen(in(name), "w");
  ck_assert_msg(file != NULL, "%s: %s", name, strerror(errno));
  fclose(file);
}

static bool there(const char *name) {
  return access(in(name), F_OK) == 0;
}

static bool is_json(const char *path) {
  char command[400];
  snprintf(command, sizeof command, "/usr/bin/python3 -c 'import json,sys; json.load(open(sys.argv[1]))' %s",
           path);
  return system("test -x /usr/bin/python3") != 0 || system(command) == 0;
}

START_TEST(numbers_round_trip) {
  char text[HC_TEXT_NUMBER];
  ck_assert_str_eq(hc_text_number(text, 0.1), "0.1");
  ck_assert_str_eq(hc_text_number(text, -0.0), "-0");
  ck_assert_str_eq(hc_text_number(text, NAN), "nan");
  ck_assert_str_eq(hc_text_number(text, -INFINITY), "-inf");
  uint64_t bits = 12345;
  bool good = true;
  for (int k = 0; k < 10000; k++) {
    bits = bits * 6364136223846793005 + 1442695040888963407;
    double value;
    memcpy(&value, &bits, sizeof value);
    if (isfinite(value)) good &= strtod(hc_text_number(text, value), NULL) == value;
  }
  ck_assert(good);
}
END_TEST

static hc_step_row step_row(int64_t step) {
  return (hc_step_row){.step = step,
                       .time = 0.1 * (double)step,
                       .dt = 1e-3,
                       .iterations_density = 3,
                       .iterations_divergence = 4,
                       .density_error_avg = 1e-4,
                       .v_max = 2.5,
                       .fluid_particles = 1000,
                       .force_max = 9.5,
                       .active_fraction = 1,
                       .substeps = 1,
                       .active_boundary_fraction = 0.25,
                       .event = step == 2 ? "rollback+cap" : NULL};
}

START_TEST(tables_hold_their_rows) {
  hc_tables tables;
  ck_assert_int_eq(hc_tables_open(&tables, directory, "", -1, 0, &error), HC_OK);
  for (int64_t step = 1; step <= 2; step++) {
    const hc_step_row row = step_row(step);
    const hc_load_row load = {step, 0.5, 1.25, 17, 4096, "snapshot"};
    ck_assert_int_eq(hc_tables_add_step(&tables, &row, &error), HC_OK);
    ck_assert_int_eq(hc_tables_add_load(&tables, &load, &error), HC_OK);
  }
  const char *const steps =
      "step,time,dt,iterations_density,iterations_divergence,density_error_avg,density_error_max,v_max,a_max,"
      "kinetic_energy,potential_energy,fluid_particles,active_fraction,active_boundary_fraction,event,force_"
      "max,substeps\n"
      "1,0.1,0.001,3,4,0.0001,0,2.5,0,0,0,1000,1,0.25,,9.5,1\n"
      "2,0.2,0.001,3,4,0.0001,0,2.5,0,0,0,1000,1,0.25,rollback+cap,9.5,1\n";
  ck_assert_str_eq(content("steps.csv"), steps); /* before the close: every row is in the file */
  ck_assert_int_eq(hc_tables_close(&tables, &error), HC_OK);
  ck_assert_str_eq(content("load.csv"), "step,wall_seconds,imbalance,ghosts_max,bytes_sent_max,event\n"
                                        "1,0.5,1.25,17,4096,snapshot\n2,0.5,1.25,17,4096,snapshot\n");
}
END_TEST

START_TEST(tables_go_on_after_a_restart) {
  hc_tables tables;
  ck_assert_int_eq(hc_tables_open(&tables, directory, "", -1, 0, &error), HC_OK);
  for (int64_t step = 1; step <= 9; step++) {
    const hc_step_row row = step_row(step);
    ck_assert_int_eq(hc_tables_add_step(&tables, &row, &error), HC_OK);
  }
  fputs("10,0.99", tables.steps.stream); /* a row cut short */
  ck_assert_int_eq(hc_tables_close(&tables, &error), HC_OK);
  char whole[8192];
  snprintf(whole, sizeof whole, "%.8000s", content("steps.csv"));
  ck_assert_int_eq(hc_tables_open(&tables, directory, "", 5, 0, &error), HC_OK);
  for (int64_t step = 6; step <= 9; step++) {
    const hc_step_row row = step_row(step);
    ck_assert_int_eq(hc_tables_add_step(&tables, &row, &error), HC_OK);
  }
  ck_assert_int_eq(hc_tables_close(&tables, &error), HC_OK);
  *strstr(whole, "10,0.99") = 0;
  ck_assert_str_eq(content("steps.csv"), whole);
  FILE *file = fopen(in("load.csv"), "w");
  fputs("step,else\n1,2\n", file);
  fclose(file);
  ck_assert_int_eq(hc_tables_open(&tables, directory, "", 5, 0, &error), HC_IO_FAILED);
  ck_assert_msg(strstr(error.text, "its first line must be step,wall_seconds"), "%s", error.text);
}
END_TEST

START_TEST(tables_take_rows_back) {
  hc_tables tables;
  ck_assert_int_eq(hc_tables_open(&tables, directory, ",depth", -1, 0, &error), HC_OK);
  char whole[3][4096] = {""};
  static const char *const names[] = {"steps.csv", "load.csv", "gauges.csv"};
  for (int round = 0; round < 3; round++) { /* of five rows each, of which two are taken back */
    for (int64_t step = 3 * round + 1; step <= 3 * round + 5; step++) {
      const hc_step_row row = step_row(step);
      const hc_load_row load = {step, 0.5, 1.25, 17, 4096, ""};
      const double depth = 0.5;
      ck_assert_int_eq(hc_tables_add_step(&tables, &row, &error), HC_OK);
      ck_assert_int_eq(hc_tables_add_load(&tables, &load, &error), HC_OK);
      ck_assert_int_eq(hc_tables_add_gauges(&tables, row.time, &depth, 1, &error), HC_OK);
      if (step == 3 * round + 3)
        for (int k = 0; k < 3; k++) snprintf(whole[k], sizeof whole[k], "%.4000s", content(names[k]));
    }
    ck_assert_int_eq(hc_tables_cut(&tables, 3 * round + 3, step_row(3 * round + 3).time, &error), HC_OK);
    for (int k = 0; k < 3; k++) ck_assert_str_eq(content(names[k]), whole[k]);
  }
  ck_assert_int_eq(hc_tables_cut(&tables, 99, 99.0, &error), HC_OK); /* nothing */
  ck_assert_str_eq(content("steps.csv"), whole[0]);
  ck_assert_int_eq(hc_tables_close(&tables, &error), HC_OK);
  hc_tables none = {0};
  ck_assert_int_eq(hc_tables_cut(&none, 1, 1.0, &error), HC_OK);
}
END_TEST

/* Bytes that this process has read. */
static long long bytes_read(void) {
  FILE *file = fopen("/proc/self/io", "r");
  long long bytes = 0;
  ck_assert(file && fscanf(file, "rchar: %lld", &bytes) == 1);
  fclose(file);
  return bytes;
}

START_TEST(long_tables_are_not_read_to_take_rows_back) {
  enum { ROWS = 100000, CUTS = 20 };
  hc_tables tables;
  ck_assert_int_eq(hc_tables_open(&tables, directory, "", -1, 0, &error), HC_OK);
  for (int64_t step = 1; step <= ROWS; step++) {
    const hc_step_row row = step_row(step);
    ck_assert_int_eq(hc_tables_add_step(&tables, &row, &error), HC_OK);
  }
  const long long before = bytes_read();
  for (int k = 1; k <= CUTS; k++) ck_assert_int_eq(hc_tables_cut(&tables, ROWS - 2 * k, 0, &error), HC_OK);
  ck_assert_int_lt(bytes_read() - before, CUTS * 200000);
  char last[256];
  for (int64_t step = ROWS - 2 * CUTS; step > 0; step = step / 3 - 10) { /* also far back */
    ck_assert_int_eq(hc_tables_cut(&tables, step, 0, &error), HC_OK);
    FILE *file = fopen(in("steps.csv"), "r");
    int64_t rows = -1;
    while (fgets(last, sizeof last, file)) rows++;
    fclose(file);
    ck_assert_int_eq(rows, step);
    ck_assert_int_eq(atoll(last), step);
  }
  ck_assert_int_eq(hc_tables_cut(&tables, 0, 0, &error), HC_OK);
  ck_assert_str_eq(strchr(content("steps.csv"), '\n'), "\n");
  ck_assert_int_eq(hc_tables_close(&tables, &error), HC_OK);
}
END_TEST

START_TEST(rows_longer_than_a_window_are_taken_back) {
  enum { COLUMNS = 10000 };
  char *names = hc_alloc_zero(3 * COLUMNS, 1);
  double *values = hc_alloc(COLUMNS, sizeof *values);
  for (int k = 0; k < COLUMNS; k++) {
    strcat(names + 2 * k, ",x");
    values[k] = 1.0 / (k + 3);
  }
  hc_tables tables;
  ck_assert_int_eq(hc_tables_open(&tables, directory, names, -1, 0, &error), HC_OK);
  for (int row = 1; row <= 4; row++)
    ck_assert_int_eq(hc_tables_add_gauges(&tables, row, values, COLUMNS, &error), HC_OK);
  struct stat two, whole;
  ck_assert_int_eq(stat(in("gauges.csv"), &whole), 0);
  ck_assert_int_gt(whole.st_size, 4 * (2 << 16));
  ck_assert_int_eq(hc_tables_cut(&tables, 0, 2.5, &error), HC_OK);
  ck_assert_int_eq(stat(in("gauges.csv"), &two), 0);
  ck_assert_int_eq(whole.st_size - two.st_size, two.st_size - (4 + 2 * COLUMNS + 1)); /* two rows of four */
  ck_assert_int_eq(hc_tables_close(&tables, &error), HC_OK);
  hc_free(names);
  hc_free(values);
}
END_TEST

START_TEST(a_full_disk_ends_a_table) {
  hc_tables tables;
  ck_assert_int_eq(symlink("/dev/full", in("load.csv")), 0);
  ck_assert_int_eq(hc_tables_open(&tables, directory, "", -1, 0, &error), HC_IO_FAILED);
  ck_assert_msg(strstr(error.text, "load.csv: No space left"), "%s", error.text);
  ck_assert_int_eq(unlink(in("load.csv")), 0);
  ck_assert_int_eq(hc_tables_open(&tables, directory, "", -1, 0, &error), HC_OK);
  tables.steps.stream = freopen("/dev/full", "w", tables.steps.stream);
  const hc_step_row row = step_row(1);
  ck_assert_int_eq(hc_tables_add_step(&tables, &row, &error), HC_IO_FAILED);
  ck_assert_int_eq(hc_tables_close(&tables, &error), HC_IO_FAILED);
}
END_TEST

START_TEST(other_ranks_tables_and_logs_do_nothing) {
  hc_tables tables = {0};
  hc_log log = {0};
  hc_progress progress = {0};
  const hc_step_row row = step_row(1);
  const hc_progress_sample sample = {0};
  ck_assert_int_eq(hc_tables_add_step(&tables, &row, &error), HC_OK);
  ck_assert_int_eq(hc_tables_close(&tables, &error), HC_OK);
  hc_log_info(&log, "nothing");
  hc_log_warn(&log, "nothing");
  ck_assert_int_eq(hc_log_close(&log, &error), HC_OK);
  hc_progress_step(&progress, &sample);
  hc_progress_finish(&progress, &sample);
}
END_TEST

START_TEST(a_log_echoes_a_kind_of_warning_once) {
  hc_log log;
  ck_assert_int_eq(hc_log_open(&log, directory, false, &error), HC_OK);
  log.echo = fopen(in("echo"), "w");
  hc_log_info(&log, "version %s\non %d ranks", "0.1", 3);
  for (int k = 0; k < 3; k++) hc_log_warn(&log, "particle %d left the domain", k);
  hc_log_warn(&log, "odd");
  fclose(log.echo);
  ck_assert_int_eq(hc_log_close(&log, &error), HC_OK);
  ck_assert_str_eq(content("echo"),
                   "halocline: warning: particle 0 left the domain\nhalocline: warning: odd\n");
  const char *text = content("run.log");
  ck_assert_msg(strstr(text, " info version 0.1\n") && strstr(text, " info on 3 ranks\n") &&
                    strstr(text, " warning particle 2 left the domain\n"),
                "%s", text);
  ck_assert_int_eq(hc_log_open(&log, in("missing"), false, &error), HC_IO_FAILED);
}
END_TEST

START_TEST(progress_tells_the_run) {
  FILE *stream = fopen(in("progress"), "w");
  hc_progress progress;
  hc_progress_start(&progress, stream, false, 0, 2);
  const hc_progress_sample sample = {7, 0.5, 1e-3, 3, 2, 1e-4, 1000, 1.05};
  hc_progress_step(&progress, &sample); /* too early for a line */
  hc_progress_finish(&progress, &sample);
  fclose(stream);
  const char *text = content("progress");
  ck_assert_msg(strstr(text, "0.5000/2 s  25%  step 7  dt 0.001 s  iterations 3+2  density error 0.01%"),
                "%s", text);
  ck_assert_ptr_eq(strchr(text, '\n'), text + strlen(text) - 1);
  ck_assert(!hc_progress_on_terminal(stdin) || isatty(0));
}
END_TEST

START_TEST(warnings_of_a_kind_become_rare) {
  hc_log log;
  ck_assert_int_eq(hc_log_open(&log, directory, false, &error), HC_OK);
  FILE *echo = log.echo = tmpfile();
  for (int64_t number = 1; number <= 12345; number++)
    hc_log_warn_counted(&log, number, "step %d: too much", (int)number + 7);
  ck_assert_int_eq(hc_log_close(&log, &error), HC_OK);
  const char *text = content("run.log");
  int lines = 0;
  for (const char *c = text; *c; c++) lines += *c == '\n';
  ck_assert_int_eq(lines, 13); /* 1 to 10, 100, 1000, 10000 */
  ck_assert_msg(strstr(text, "warning step 8: too much\n") &&
                    strstr(text, "warning step 17: too much; further ones are counted") &&
                    !strstr(text, "step 18:") &&
                    strstr(text, "warning step 1007: too much; the 1000th of its kind\n"),
                "%s", text);
  ck_assert_int_eq(ftell(echo), strlen("halocline: warning: step 8: too much\n"));
  fclose(echo);
}
END_TEST

START_TEST(json_has_commas_lines_and_escapes) {
  hc_json json;
  FILE *file = fopen(in("x.json"), "w");
  hc_json_begin(&json, file, false);
  hc_json_object(&json, NULL, HC_JSON_DENSE);
  hc_json_string(&json, "a\"\\", "line\nend \x7f \u00e9");
  hc_json_list(&json, "b", HC_JSON_LINES);
  hc_json_number(&json, NULL, 0.1);
  hc_json_number(&json, NULL, NAN);
  hc_json_null(&json, NULL);
  hc_json_end(&json);
  hc_json_list(&json, "c", HC_JSON_DENSE);
  hc_json_end(&json);
  hc_json_id(&json, "d", UINT64_MAX);
  hc_json_integer(&json, "e", INT64_MIN);
  hc_json_extent(&json, "f", false, NULL, NULL);
  hc_json_bool(&json, "g", false);
  hc_json_end(&json);
  fclose(file);
  ck_assert(is_json(in("x.json")));
  ck_assert_str_eq(content("x.json"),
                   "{\"a\\\"\\\\\":\"line\\u000aend \\u007f \u00e9\",\"b\":[\n  0.1,\n  null,\n"
                   "  null\n],\"c\":[],\"d\":18446744073709551615,\"e\":-9223372036854775808,"
                   "\"f\":null,\"g\":false}\n");
}
END_TEST

START_TEST(timings_are_valid_json) {
  const hc_timings_stage stages[] = {{"density \"solve\"", {1, 2, 3}}, {"halo", {0.1, 0.2, NAN}}};
  hc_timings timings = {.ranks = 2,
                        .steps = 10,
                        .fluid_particles = 1000,
                        .particle_steps = 1e4,
                        .wall_seconds = 2,
                        .stages = stages,
                        .stage_count = 2};
  ck_assert_int_eq(hc_timings_write(&timings, directory, &error), HC_OK);
  ck_assert(is_json(in("timings.json")));
  const char *text = content("timings.json");
  ck_assert_msg(strstr(text, "\"particle_steps_per_second\": 5000,") &&
                    strstr(text, "\"ns_per_particle_step\": 200000,") &&
                    strstr(text, "\"density \\\"solve\\\"\": {\"min\": 1, \"mean\": 2, \"max\": 3}"),
                "%s", text);
  timings.stage_count = 0;
  timings.particle_steps = timings.wall_seconds = 0;
  ck_assert_int_eq(hc_timings_write(&timings, directory, &error), HC_OK);
  ck_assert(is_json(in("timings.json")) && !there(".timings.json.tmp"));
  ck_assert_int_eq(hc_timings_write(&timings, in("missing"), &error), HC_IO_FAILED);
}
END_TEST

START_TEST(the_series_grows_and_turns_back) {
  for (int k = 0; k < 4; k++) ck_assert_int_eq(hc_series_add(directory, k, 0.05 * k, &error), HC_OK);
  ck_assert(is_json(in("run.hdf.series")));
  ck_assert_int_eq(hc_series_add(directory, 2, 0.11, &error), HC_OK);
  ck_assert_str_eq(content("run.hdf.series"), "{\"file-series-version\":\"1.0\",\"files\":[\n"
                                              "  {\"name\":\"snap_000000.hdf\",\"time\":0},\n"
                                              "  {\"name\":\"snap_000001.hdf\",\"time\":0.05},\n"
                                              "  {\"name\":\"snap_000002.hdf\",\"time\":0.11}\n]}\n");
}
END_TEST

START_TEST(a_run_directory_is_made_with_its_parents) {
  ck_assert_int_eq(hc_run_dir_open(&comm, in("a/b//c/"), HC_RUN_DIR_NEW, &error), HC_OK);
  ck_assert(there("a/b/c"));
  ck_assert_int_eq(hc_run_dir_open(&comm, in("a/b/c"), HC_RUN_DIR_NEW, &error), HC_OK);
  touch("file");
  ck_assert_int_eq(hc_run_dir_open(&comm, in("file"), HC_RUN_DIR_NEW, &error), HC_IO_FAILED);
  ck_assert_msg(strstr(error.text, "a file of that name is in the way"), "%s", error.text);
  ck_assert_int_eq(hc_run_dir_open(&comm, in("file/below"), HC_RUN_DIR_NEW, &error), HC_IO_FAILED);
  ck_assert_msg(strstr(error.text, "Not a directory"), "%s", error.text);
  ck_assert_int_eq(hc_run_dir_open(&comm, "", HC_RUN_DIR_NEW, &error), HC_BAD_INPUT);
}
END_TEST

START_TEST(force_removes_the_runs_own_files_only) {
  static const char *const own[] = {"steps.csv",
                                    "load.csv",
                                    "run.log",
                                    "timings.json",
                                    "scene.yaml",
                                    "gauges.csv",
                                    "snapshots/snap_000000.hdf",
                                    "snapshots/snap_1000000.hdf",
                                    "snapshots/.snap_000003.hdf.tmp",
                                    "snapshots/fault_000012.hdf",
                                    "snapshots/run.hdf.series",
                                    "checkpoints/ckpt_00000010.h5"};
  static const char *const others[] = {
      "notes.txt",           "snapshots/snap_mine.hdf", "snapshots/snap_000001.hdf.bak",
      "snapshots/snap_.hdf", "checkpoints/README",      "steps.csv.old"};
  ck_assert_int_eq(mkdir(in("snapshots"), 0777) | mkdir(in("checkpoints"), 0777), 0);
  for (size_t k = 0; k < sizeof own / sizeof *own; k++) touch(own[k]);
  for (size_t k = 0; k < sizeof others / sizeof *others; k++) touch(others[k]);
  ck_assert_int_eq(hc_run_dir_open(&comm, directory, HC_RUN_DIR_NEW, &error), HC_BAD_INPUT);
  ck_assert_msg(strstr(error.text, "already holds a run (steps.csv)") && strstr(error.text, "--force"), "%s",
                error.text);
  ck_assert_int_eq(hc_run_dir_open(&comm, directory, HC_RUN_DIR_RESUME, &error), HC_OK);
  for (size_t k = 0; k < sizeof own / sizeof *own; k++) ck_assert_msg(there(own[k]), "%s is gone", own[k]);
  ck_assert_int_eq(hc_run_dir_open(&comm, directory, HC_RUN_DIR_FORCE, &error), HC_OK);
  for (size_t k = 0; k < sizeof own / sizeof *own; k++)
    ck_assert_msg(!there(own[k]), "%s is still there", own[k]);
  for (size_t k = 0; k < sizeof others / sizeof *others; k++)
    ck_assert_msg(there(others[k]), "%s is gone", others[k]);
  ck_assert_int_eq(hc_run_dir_open(&comm, directory, HC_RUN_DIR_NEW, &error), HC_OK);
}
END_TEST

int main(int argc, char **argv) {
  hc_comm_start(&comm, &argc, &argv);
  TCase *tests = tcase_create("files");
  tcase_add_checked_fixture(tests, setup, teardown);
  tcase_add_test(tests, numbers_round_trip);
  tcase_add_test(tests, tables_hold_their_rows);
  tcase_add_test(tests, tables_go_on_after_a_restart);
  tcase_add_test(tests, tables_take_rows_back);
  tcase_add_test(tests, long_tables_are_not_read_to_take_rows_back);
  tcase_add_test(tests, rows_longer_than_a_window_are_taken_back);
  tcase_add_test(tests, a_full_disk_ends_a_table);
  tcase_add_test(tests, other_ranks_tables_and_logs_do_nothing);
  tcase_add_test(tests, a_log_echoes_a_kind_of_warning_once);
  tcase_add_test(tests, progress_tells_the_run);
  tcase_add_test(tests, warnings_of_a_kind_become_rare);
  tcase_add_test(tests, json_has_commas_lines_and_escapes);
  tcase_add_test(tests, timings_are_valid_json);
  tcase_add_test(tests, the_series_grows_and_turns_back);
  tcase_add_test(tests, a_run_directory_is_made_with_its_parents);
  tcase_add_test(tests, force_removes_the_runs_own_files_only);
  Suite *suite = suite_create("io files");
  suite_add_tcase(suite, tests);
  SRunner *runner = srunner_create(suite);
  srunner_set_fork_status(runner, CK_NOFORK); /* MPI does not survive a fork */
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  hc_comm_finish(&comm);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
