#include "series.h"

#include "atomic_file.h"
#include "base/memory.h"
#include "json.h"
#include "numbered.h"
#include "snapshot_read.h"
#include "text.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static void put_entry(hc_json *json, int number, double time) {
  char name[32];
  snprintf(name, sizeof name, "snap_%06d.hdf", number);
  hc_json_object(json, NULL, HC_JSON_DENSE);
  hc_json_string(json, "name", name);
  hc_json_number(json, "time", time);
  hc_json_end(json);
}

/* The series with its entries before `number`, and one more of that number and time unless `cut`. */
static hc_status rewrite(const char *directory, int number, bool cut, double time, hc_error *error) {
  char path[HC_TEXT_PATH];
  hc_atomic_file file;
  hc_status status = hc_text_path(path, error, "%s/run.hdf.series", directory);
  if (status == HC_OK) status = hc_atomic_file_begin(&file, directory, "run.hdf.series", error);
  if (status != HC_OK) return status;
  hc_json json;
  hc_json_begin(&json, file.stream, false);
  hc_json_object(&json, NULL, HC_JSON_DENSE);
  hc_json_string(&json, "file-series-version", "1.0");
  hc_json_list(&json, "files", HC_JSON_LINES);
  FILE *old = fopen(path, "r");
  bool lost = !old && errno != ENOENT; /* entries that are there but cannot be read are not dropped */
  if (old) {
    char line[256];
    while (fgets(line, sizeof line, old)) {
      int old_number = 0;
      double old_time = 0;
      if (sscanf(line, " {\"name\":\"snap_%d.hdf\",\"time\":%lf}", &old_number, &old_time) != 2) continue;
      if (old_number < number) put_entry(&json, old_number, old_time);
    }
    lost = ferror(old) != 0;
    fclose(old);
  }
  if (lost) {
    hc_atomic_file_abandon(&file);
    return hc_error_set(error, HC_IO_FAILED, "cannot read %s: %s", path, strerror(errno ? errno : EIO));
  }
  if (!cut) put_entry(&json, number, time);
  hc_json_end(&json);
  hc_json_end(&json);
  return hc_atomic_file_commit(&file, error);
}

hc_status hc_series_add(const char *directory, int number, double time, hc_error *error) {
  return rewrite(directory, number, false, time, error);
}

static hc_status add_from_file(const char *directory, int number, hc_error *error) {
  char path[HC_TEXT_PATH];
  hc_snapshot_file file;
  hc_error unreadable = {.status = HC_OK};
  if (hc_text_path(path, error, "%s/snap_%06d.hdf", directory, number) != HC_OK) return error->status;
  if (hc_snapshot_read_open(path, &file, &unreadable) != HC_OK) return HC_OK;
  const double time = file.facts.time;
  hc_snapshot_read_close(&file);
  return hc_series_add(directory, number, time, error);
}

hc_status hc_series_restore(const char *directory, int number, bool *made, hc_error *error) {
  char path[HC_TEXT_PATH];
  int64_t *numbers;
  size_t count = 0;
  *made = false;
  hc_status status = hc_text_path(path, error, "%s/run.hdf.series", directory);
  if (status != HC_OK || access(path, F_OK) == 0) return status;
  status = hc_numbered_list(&(hc_numbered){directory, "snap_", ".hdf"}, &numbers, &count, error);
  if (status != HC_OK) return status;
  for (size_t k = count; k-- > 0 && status == HC_OK;) /* the largest stands first */
    if (numbers[k] < number) {
      status = add_from_file(directory, (int)numbers[k], error);
      *made = true;
    }
  hc_free(numbers);
  return status;
}

hc_status hc_series_cut(const char *directory, int number, hc_error *error) {
  char path[HC_TEXT_PATH];
  const hc_status status = hc_text_path(path, error, "%s/run.hdf.series", directory);
  if (status != HC_OK || access(path, F_OK) != 0) return status;
  return rewrite(directory, number, true, 0.0, error);
}
