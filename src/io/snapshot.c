#include "snapshot.h"

#include "series.h"
#include "shared_file.h"
#include "snapshot_layout.h"

#include <stdio.h>

/* A snapshot of the run's series, or of a fault. */
typedef struct place {
  const char *directory, *stem;
  int number;
  bool in_series;
} place;

/* Everything between the counts and the finished file. Collective; afterwards `problem` is agreed. */
static void write_file(hc_snapshot_layout *layout, const place *place, hc_error *problem) {
  hc_shared_file file;
  char name[32];
  snprintf(name, sizeof name, "%s_%06d.hdf", place->stem, place->number);
  if (hc_shared_file_open(&file, layout->comm, place->directory, "snapshots", name,
                          hc_snapshot_layout_bytes(layout), 0, problem) == HC_OK) {
    layout->file = file.handle;
    hc_snapshot_layout_define(layout);
    if (hc_comm_agree(layout->comm, problem) == HC_OK) hc_snapshot_layout_fill(layout);
    hc_snapshot_layout_close(layout);
    hc_shared_file_close(&file);
  }
  if (hc_shared_file_end(&file) == HC_OK && layout->comm->rank == 0 && place->in_series)
    hc_series_add(file.directory, place->number, layout->moment->time, problem);
  hc_comm_agree(layout->comm, problem);
}

static hc_status write_snapshot(hc_comm *comm, const hc_scene *scene, const hc_moment *moment,
                                const place *place, hc_error *error) {
  hc_error problem = {.status = HC_OK};
  hc_snapshot_layout layout;
  hc_snapshot_layout_init(&layout, comm, scene, moment, &problem);
  if (hc_comm_agree(comm, &problem) == HC_OK) write_file(&layout, place, &problem);
  hc_snapshot_layout_free(&layout);
  if (problem.status != HC_OK) {
    char reason[HC_ERROR_TEXT - 192];
    snprintf(reason, sizeof reason, "%.*s", (int)sizeof reason - 1, problem.text);
    hc_error_set(error, problem.status, "snapshot %d: %s", place->number, reason);
  }
  return problem.status;
}

hc_status hc_snapshot_write(hc_comm *comm, const hc_scene *scene, const hc_moment *moment,
                            const char *directory, int number, hc_error *error) {
  const place place = {directory, "snap", number, true};
  return write_snapshot(comm, scene, moment, &place, error);
}

hc_status hc_snapshot_write_fault(hc_comm *comm, const hc_scene *scene, const hc_moment *moment,
                                  const char *directory, hc_error *error) {
  const place place = {directory, "fault", (int)moment->step, false};
  return write_snapshot(comm, scene, moment, &place, error);
}

hc_status hc_snapshot_bytes(const hc_scene *scene, int64_t particles, int64_t *bytes, hc_error *error) {
  hc_error problem = {.status = HC_OK};
  *bytes = hc_snapshot_layout_estimate(scene, particles, &problem);
  if (problem.status != HC_OK && error) *error = problem;
  return problem.status;
}
