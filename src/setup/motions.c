#include "motions.h"

#include "base/memory.h"
#include "comm/comm.h"
#include "scene/motion_file.h"
#include "scene/source_rules.h"

#include <stdio.h>

/* Rank 0's table on all ranks. */
static void share(hc_comm *comm, hc_wall_motion *motion, hc_error *error) {
  hc_comm_broadcast(comm, error, sizeof *error, 0);
  if (error->status != HC_OK) return;
  hc_comm_broadcast(comm, &motion->point_count, sizeof motion->point_count, 0);
  if (comm->rank != 0) {
    hc_free(motion->points);
    motion->points = hc_alloc((size_t)motion->point_count, sizeof *motion->points);
    motion->file[0] = '\0';
  }
  hc_comm_broadcast(comm, motion->points, (size_t)motion->point_count * sizeof *motion->points, 0);
}

void hc_setup_motions_load(void *context, hc_scene *scene, const char *name, hc_findings *findings) {
  hc_comm *const comm = context;
  const hc_given_value *const walls = hc_given_value_of(findings->given, "boundary.walls");
  hc_error *const error = hc_alloc(1, sizeof *error);
  for (int k = 0; k < scene->boundary.wall_count; k++) {
    hc_wall *const wall = &scene->boundary.walls[k];
    if (!hc_motion_file_pending(wall)) continue;
    char path[64];
    snprintf(path, sizeof path, "boundary.walls[%d].motion.file", k);
    *error = (hc_error){.status = HC_OK};
    if (!comm || comm->rank == 0) hc_motion_file_read(wall, k, name, error);
    if (comm) share(comm, &wall->motion, error);
    if (error->status != HC_OK)
      hc_findings_error(findings, path, "%s", error->text);
    else
      hc_source_rules_loaded(wall, &walls->items[k], findings->errors);
  }
  hc_free(error);
}
