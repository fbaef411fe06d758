#include "series.h"

#include "atomic_file.h"
#include "text.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static void put_entry(FILE *stream, bool first, int number, double time) {
  char text[HC_TEXT_NUMBER];
  fprintf(stream, "%s  {\"name\":\"snap_%06d.hdf\",\"time\":%s}", first ? "" : ",\n", number,
          hc_text_json_number(text, time));
}

/* The series with its entries before `number`, and one more of that number and time unless `cut`. */
static hc_status rewrite(const char *directory, int number, bool cut, double time, hc_error *error) {
  char path[HC_TEXT_PATH];
  hc_atomic_file file;
  hc_status status = hc_text_path(path, error, "%s/run.hdf.series", directory);
  if (status == HC_OK) status = hc_atomic_file_begin(&file, directory, "run.hdf.series", error);
  if (status != HC_OK) return status;
  fprintf(file.stream, "{\"file-series-version\":\"1.0\",\"files\":[\n");
  bool first = true;
  FILE *old = fopen(path, "r");
  bool lost = !old && errno != ENOENT; /* entries that are there but cannot be read are not dropped */
  if (old) {
    char line[256];
    while (fgets(line, sizeof line, old)) {
      int old_number = 0;
      double old_time = 0;
      if (sscanf(line, " {\"name\":\"snap_%d.hdf\",\"time\":%lf}", &old_number, &old_time) != 2) continue;
      if (old_number >= number) continue;
      put_entry(file.stream, first, old_number, old_time);
      first = false;
    }
    lost = ferror(old) != 0;
    fclose(old);
  }
  if (lost) {
    hc_atomic_file_abandon(&file);
    return hc_error_set(error, HC_IO_FAILED, "cannot read %s: %s", path, strerror(errno ? errno : EIO));
  }
  if (!cut) put_entry(file.stream, first, number, time);
  fprintf(file.stream, "\n]}\n");
  return hc_atomic_file_commit(&file, error);
}

hc_status hc_series_add(const char *directory, int number, double time, hc_error *error) {
  return rewrite(directory, number, false, time, error);
}

hc_status hc_series_cut(const char *directory, int number, hc_error *error) {
  char path[HC_TEXT_PATH];
  const hc_status status = hc_text_path(path, error, "%s/run.hdf.series", directory);
  if (status != HC_OK || access(path, F_OK) != 0) return status;
  return rewrite(directory, number, true, 0.0, error);
}
