#include "tables.h"

#include "base/check.h"
#include "base/memory.h"

#include <errno.h>
#include <inttypes.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- the columns ---- */

typedef enum column_kind { WHOLE, WHOLE_64, NUMBER, EVENT } column_kind;

/* A column is a member of a row. */
typedef struct column {
  const char *name;
  column_kind kind;
  size_t offset;
} column;

#define STEP(member, kind)                                                                                   \
  { #member, kind, offsetof(hc_step_row, member) }
#define LOAD(member, kind)                                                                                   \
  { #member, kind, offsetof(hc_load_row, member) }

/* The first column is the step, by which rows are found again. */
static const column step_columns[] = {STEP(step, WHOLE_64),
                                      STEP(time, NUMBER),
                                      STEP(dt, NUMBER),
                                      STEP(iterations_density, WHOLE),
                                      STEP(iterations_divergence, WHOLE),
                                      STEP(density_error_avg, NUMBER),
                                      STEP(density_error_max, NUMBER),
                                      STEP(v_max, NUMBER),
                                      STEP(a_max, NUMBER),
                                      STEP(kinetic_energy, NUMBER),
                                      STEP(potential_energy, NUMBER),
                                      STEP(fluid_particles, WHOLE_64),
                                      STEP(active_fraction, NUMBER),
                                      STEP(active_boundary_fraction, NUMBER),
                                      STEP(event, EVENT),
                                      STEP(force_max, NUMBER),
                                      STEP(substeps, WHOLE)};
static const column load_columns[] = {LOAD(step, WHOLE_64),           LOAD(wall_seconds, NUMBER),
                                      LOAD(imbalance, NUMBER),        LOAD(ghosts_max, WHOLE_64),
                                      LOAD(bytes_sent_max, WHOLE_64), LOAD(event, EVENT)};
enum {
  STEP_COLUMNS = sizeof step_columns / sizeof *step_columns,
  LOAD_COLUMNS = sizeof load_columns / sizeof *load_columns,
  HEADER = 512 /* bytes of room for a line of names */
};

static void name_columns(const column *columns, int count, char header[HEADER]) {
  int length = 0;
  for (int k = 0; k < count; k++)
    length += snprintf(header + length, (size_t)(HEADER - length), "%s%s", k ? "," : "", columns[k].name);
  snprintf(header + length, (size_t)(HEADER - length), "\n");
}

static void put_number(FILE *stream, double value) {
  char text[HC_TEXT_NUMBER];
  fputs(hc_text_number(text, value), stream);
}

static void put_event(FILE *stream, const char *event) {
  if (!event) event = "";
  HC_CHECK(!strpbrk(event, ",\"\r\n"), "an event must not hold a comma, quote or line end, got %s", event);
  fputs(event, stream);
}

static void put_row(FILE *stream, const column *columns, int count, const void *row) {
  for (int k = 0; k < count; k++) {
    const void *value = (const char *)row + columns[k].offset;
    if (k) fputc(',', stream);
    switch (columns[k].kind) {
    case WHOLE:
      fprintf(stream, "%d", *(const int *)value);
      break;
    case WHOLE_64:
      fprintf(stream, "%" PRId64, *(const int64_t *)value);
      break;
    case NUMBER:
      put_number(stream, *(const double *)value);
      break;
    case EVENT:
      put_event(stream, *(const char *const *)value);
      break;
    }
  }
  fputc('\n', stream);
}

/* ---- the files ---- */

static hc_status failed(const hc_table *table, hc_error *error) {
  return hc_error_set(error, HC_IO_FAILED, "cannot write %s: %s", table->path, strerror(errno));
}

/* A stream that failed once stays failed, also if the disk has room again: a row would be torn. */
static hc_status flush(hc_table *table, hc_error *error) {
  errno = 0;
  if (fflush(table->stream) == 0 && !ferror(table->stream)) return HC_OK;
  if (errno == 0) errno = EIO;
  return failed(table, error);
}

static hc_status unreadable(const hc_table *table, hc_error *error) {
  return hc_error_set(error, HC_IO_FAILED, "cannot read %s: %s", table->path, strerror(errno ? errno : EIO));
}

/* The end of the last whole row in `text` whose first number is at most `last`; 0: there is none. */
static size_t end_of_rows(const char *text, size_t length, double last) {
  size_t end = 0;
  for (const char *row = text, *stop; (stop = memchr(row, '\n', length - (size_t)(row - text)));
       row = stop + 1) {
    char *behind;
    const double first = strtod(row, &behind);
    if (behind != row && behind <= stop && first <= last) end = (size_t)(stop + 1 - text);
  }
  return end;
}

/* Reads the bytes from `begin` on, with a zero behind them. */
static bool read_at(const hc_table *table, off_t begin, char *text, size_t length) {
  text[length] = '\0';
  for (size_t done = 0; done < length;) {
    errno = 0;
    const ssize_t got = pread(fileno(table->stream), text + done, length - done, begin + (off_t)done);
    if (got <= 0) return false;
    done += (size_t)got;
  }
  return true;
}

/* Finds the end of the last whole row whose first number is at most `last`, from the end of the file
 * backwards: what is taken back is short, the table may be long. */
static bool find_end(const hc_table *table, double last, off_t *end) {
  enum { WINDOW = 1 << 16 };
  size_t window = WINDOW;
  struct stat facts;
  errno = 0;
  if (fstat(fileno(table->stream), &facts) != 0) return false;
  off_t upper = facts.st_size;
  *end = table->rows;
  while (upper > table->rows) {
    const off_t lower = upper - table->rows > (off_t)window ? upper - (off_t)window : table->rows;
    const size_t length = (size_t)(upper - lower);
    char *text = hc_alloc(length + 1, 1);
    if (!read_at(table, lower, text, length)) {
      hc_free(text);
      return false;
    }
    /* Rows begin behind a line end; what is before it belongs to the next window. */
    const char *line_end = lower == table->rows ? NULL : memchr(text, '\n', length);
    const size_t skipped = line_end ? (size_t)(line_end + 1 - text) : 0;
    const bool rows = lower == table->rows || (skipped > 0 && skipped < length);
    const size_t found = rows ? end_of_rows(text + skipped, length - skipped, last) : 0;
    hc_free(text);
    if (found > 0) {
      *end = lower + (off_t)(skipped + found);
      return true;
    }
    if (lower == table->rows) return true;
    if (rows)
      upper = lower + (off_t)skipped;
    else
      window *= 2; /* a row longer than it */
  }
  return true;
}

/* Drops what is behind the rows up to `last`, and goes on from there. */
static hc_status cut(hc_table *table, double last, hc_error *error) {
  off_t end = 0;
  if (!find_end(table, last, &end)) return unreadable(table, error); /* rows that are there are not cut off */
  if (fseeko(table->stream, end, SEEK_SET) != 0 || ftruncate(fileno(table->stream), end) != 0)
    return failed(table, error);
  return HC_OK;
}

/* Is the first line ours? */
static hc_status check_header(const hc_table *table, const char *header, hc_error *error) {
  char *line = NULL;
  size_t room = 0;
  errno = 0;
  const bool ours = getline(&line, &room, table->stream) > 0 && strcmp(line, header) == 0;
  free(line);
  if (ferror(table->stream)) return unreadable(table, error);
  if (ours) return HC_OK;
  return hc_error_set(error, HC_IO_FAILED, "cannot go on in %s: its first line must be %.*s", table->path,
                      (int)strlen(header) - 1, header);
}

static hc_status open_table(hc_table *table, const char *directory, const char *name, const char *header,
                            bool go_on, double last, hc_error *error) {
  const hc_status status = hc_text_path(table->path, error, "%s/%s", directory, name);
  if (status != HC_OK) return status;
  if (go_on) {
    table->stream = fopen(table->path, "r+");
    if (!table->stream && errno != ENOENT) return failed(table, error);
  }
  table->rows = (off_t)strlen(header);
  if (table->stream)
    return check_header(table, header, error) == HC_OK ? cut(table, last, error) : error->status;
  table->stream = fopen(table->path, "w+");
  if (!table->stream) return failed(table, error);
  fputs(header, table->stream);
  return flush(table, error);
}

hc_status hc_tables_open(hc_tables *tables, const char *directory, const char *gauge_names, int64_t last_step,
                         double last_time, hc_error *error) {
  memset(tables, 0, sizeof *tables);
  const bool go_on = last_step >= 0;
  const double last = (double)last_step;
  char header[HEADER];
  name_columns(step_columns, STEP_COLUMNS, header);
  hc_status status = open_table(&tables->steps, directory, "steps.csv", header, go_on, last, error);
  name_columns(load_columns, LOAD_COLUMNS, header);
  if (status == HC_OK) status = open_table(&tables->load, directory, "load.csv", header, go_on, last, error);
  if (status == HC_OK && *gauge_names) {
    char *names = hc_alloc(strlen(gauge_names) + 8, 1);
    sprintf(names, "time%s\n", gauge_names);
    status = open_table(&tables->gauges, directory, "gauges.csv", names, go_on, last_time, error);
    hc_free(names);
  }
  if (status != HC_OK) hc_tables_close(tables, NULL);
  return status;
}

static hc_status add_row(hc_table *table, const column *columns, int count, const void *row,
                         hc_error *error) {
  if (!table->stream) return HC_OK;
  put_row(table->stream, columns, count, row);
  return flush(table, error);
}

hc_status hc_tables_add_step(hc_tables *tables, const hc_step_row *row, hc_error *error) {
  return add_row(&tables->steps, step_columns, STEP_COLUMNS, row, error);
}

hc_status hc_tables_add_load(hc_tables *tables, const hc_load_row *row, hc_error *error) {
  return add_row(&tables->load, load_columns, LOAD_COLUMNS, row, error);
}

hc_status hc_tables_add_gauges(hc_tables *tables, double time, const double *values, int count,
                               hc_error *error) {
  FILE *stream = tables->gauges.stream;
  if (!stream) return HC_OK;
  put_number(stream, time);
  for (int k = 0; k < count; k++) {
    fputc(',', stream);
    put_number(stream, values[k]);
  }
  fputc('\n', stream);
  return flush(&tables->gauges, error);
}

hc_status hc_tables_cut(hc_tables *tables, int64_t last_step, double last_time, hc_error *error) {
  hc_table *const all[] = {&tables->steps, &tables->load, &tables->gauges};
  for (int k = 0; k < 3; k++) {
    if (!all[k]->stream) continue;
    const double last = all[k] == &tables->gauges ? last_time : (double)last_step;
    if (cut(all[k], last, error) != HC_OK) return error->status;
  }
  return HC_OK;
}

hc_status hc_tables_sync(hc_tables *tables, hc_error *error) {
  hc_table *const all[] = {&tables->steps, &tables->load, &tables->gauges};
  for (int k = 0; k < 3; k++) {
    if (!all[k]->stream) continue;
    errno = 0;
    if (fsync(fileno(all[k]->stream)) != 0) return failed(all[k], error);
  }
  return HC_OK;
}

static hc_status close_table(hc_table *table, hc_error *error) {
  if (!table->stream) return HC_OK;
  const bool broken = ferror(table->stream) != 0;
  const bool closed = fclose(table->stream) == 0;
  table->stream = NULL;
  if (closed && !broken) return HC_OK;
  if (closed) errno = EIO;
  return failed(table, error);
}

hc_status hc_tables_close(hc_tables *tables, hc_error *error) {
  const hc_status steps = close_table(&tables->steps, error);
  const hc_status load = close_table(&tables->load, steps == HC_OK ? error : NULL);
  const hc_status both = steps != HC_OK ? steps : load;
  const hc_status gauges = close_table(&tables->gauges, both == HC_OK ? error : NULL);
  return both != HC_OK ? both : gauges;
}
