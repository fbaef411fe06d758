#include "movers.h"

#include "base/memory.h"
#include "particles/ids.h"

#include <math.h>
#include <string.h>

void hc_movers_init(hc_movers *moving, const hc_mover *walls, int count) {
  *moving = (hc_movers){.walls = hc_alloc((size_t)count, sizeof *walls),
                        .poses = hc_alloc_zero((size_t)count, sizeof(hc_pose)),
                        .count = count};
  if (count > 0) memcpy(moving->walls, walls, (size_t)count * sizeof *walls);
}

void hc_movers_free(hc_movers *moving) {
  hc_free(moving->walls);
  hc_free(moving->poses);
  memset(moving, 0, sizeof *moving);
}

double hc_mover_speed(const hc_mover *wall, double time, double ahead) {
  const hc_pose now = hc_motion_pose(&wall->motion, time), then = hc_motion_pose(&wall->motion, time + ahead);
  return fmax(hc_pose_speed(&now, wall->reach), hc_pose_speed(&then, wall->reach));
}

/* What rank 0 finds. */
static void evaluate(hc_movers *moving, double time, double ahead, bool held, hc_pose *poses) {
  moving->speed = 0.0;
  for (int k = 0; k < moving->count; k++) {
    const hc_mover *wall = &moving->walls[k];
    moving->speed = fmax(moving->speed, hc_mover_speed(wall, time, ahead));
    poses[k] = hc_motion_pose(&wall->motion, time);
    if (!held) continue;
    memset(poses[k].velocity, 0, sizeof poses[k].velocity);
    memset(poses[k].spin, 0, sizeof poses[k].spin);
  }
}

static bool is_moving(const hc_pose *pose) {
  return hc_pose_speed(pose, 1.0) > 0.0;
}

bool hc_movers_pose(hc_movers *moving, hc_comm *comm, double time, double ahead, bool held) {
  if (moving->count == 0 || (moving->posed && moving->time == time && !held)) return false;
  const size_t bytes = (size_t)moving->count * sizeof(hc_pose);
  hc_pose *poses = hc_alloc_zero((size_t)moving->count, sizeof *poses);
  if (comm->rank == 0) evaluate(moving, time, ahead, held, poses);
  hc_comm_broadcast(comm, poses, bytes, 0);
  hc_comm_broadcast(comm, &moving->speed, sizeof moving->speed, 0);
  const bool changed = memcmp(poses, moving->poses, bytes) != 0;
  memcpy(moving->poses, poses, bytes);
  hc_free(poses);
  moving->moving = false;
  for (int k = 0; k < moving->count; k++) moving->moving |= is_moving(&moving->poses[k]);
  moving->time = time;
  moving->posed = !held; /* what was held back is asked for again */
  return changed;
}

/* The place of a wall among those that move, or -1. */
static int find(const hc_movers *moving, int64_t wall) {
  int low = 0, high = moving->count;
  while (low < high) {
    const int middle = low + (high - low) / 2;
    if (moving->walls[middle].wall < wall)
      low = middle + 1;
    else
      high = middle;
  }
  return low < moving->count && moving->walls[low].wall == wall ? low : -1;
}

/* Finds the walls of particles that mostly come in runs of the same. */
typedef struct finder {
  const hc_movers *moving;
  int64_t wall;
  int found;
} finder;

static int find_next(finder *finder, int64_t wall) {
  if (wall != finder->wall) {
    finder->wall = wall;
    finder->found = find(finder->moving, wall);
  }
  return finder->found;
}

/* From the motion's centre to a reference position, m. */
static void arm_of(const hc_frame *frame, const hc_motion *motion, const int64_t reference[3],
                   double arm[3]) {
  for (int a = 0; a < 3; a++)
    arm[a] = (double)(reference[a] - hc_frame_to_units(frame, a, motion->centre[a])) * frame->unit[a];
}

/* turn . v, what a turn adds to a vector. */
static void turned(const hc_pose *pose, const double v[3], double added[3]) {
  for (int a = 0; a < 3; a++)
    added[a] = pose->turn[a][0] * v[0] + pose->turn[a][1] * v[1] + pose->turn[a][2] * v[2];
}

static void place(const hc_frame *frame, const hc_motion *motion, const hc_pose *pose, hc_particles *boundary,
                  int32_t k) {
  const int64_t *reference = &boundary->reference[3 * (size_t)k];
  const float *normal = &boundary->reference_normal[3 * (size_t)k];
  const double v[3] = {normal[0], normal[1], normal[2]};
  double arm[3], moved[3], leant[3];
  arm_of(frame, motion, reference, arm);
  turned(pose, arm, moved);
  turned(pose, v, leant);
  for (int a = 0; a < 3; a++) {
    const int64_t units = llrint((pose->shift[a] + moved[a]) / frame->unit[a]);
    boundary->position[3 * (size_t)k + (size_t)a] = hc_frame_wrap(frame, a, reference[a] + units);
    boundary->normal[3 * (size_t)k + (size_t)a] = (float)(v[a] + leant[a]);
  }
}

void hc_movers_start(hc_particles *boundary) {
  memcpy(boundary->reference_normal, boundary->normal, 3 * (size_t)boundary->own * sizeof *boundary->normal);
}

void hc_movers_place(const hc_movers *moving, const hc_frame *frame, hc_particles *boundary) {
  finder finder = {moving, -1, -1};
  for (int32_t k = 0; k < boundary->own; k++) {
    const int found = find_next(&finder, hc_id_source_of(boundary->id[k]));
    if (found >= 0) place(frame, &moving->walls[found].motion, &moving->poses[found], boundary, k);
  }
}

/* The velocity of a particle: v + spin x (where its arm points now). */
static hc_record velocity_of(const hc_frame *frame, const hc_motion *motion, const hc_pose *pose,
                             const int64_t reference[3]) {
  double arm[3], added[3];
  arm_of(frame, motion, reference, arm);
  turned(pose, arm, added);
  for (int a = 0; a < 3; a++) arm[a] += added[a];
  hc_record record = {.scalar = 0.0f};
  for (int a = 0; a < 3; a++) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    record.v[a] = (float)(pose->velocity[a] + (pose->spin[b] * arm[c] - pose->spin[c] * arm[b]));
  }
  return record;
}

void hc_movers_drive(const hc_movers *moving, const hc_frame *frame, hc_particles *boundary) {
  memset(boundary->motion, 0, (size_t)boundary->own * sizeof *boundary->motion);
  if (!moving->moving) return;
  finder finder = {moving, -1, -1};
  for (int32_t k = 0; k < boundary->own; k++) {
    const int found = find_next(&finder, hc_id_source_of(boundary->id[k]));
    if (found >= 0)
      boundary->motion[k] = velocity_of(frame, &moving->walls[found].motion, &moving->poses[found],
                                        &boundary->reference[3 * (size_t)k]);
  }
}

void hc_movers_part(const hc_movers *moving, const hc_particles *boundary, hc_neighbors *list) {
  if (moving->count == 0) return;
  for (int32_t i = 0; i < boundary->own; i++) {
    const int own = find(moving, (int64_t)boundary->wall[i]);
    uint32_t *row = list->offset + (size_t)list->start[i] * HC_LIST_GROUP;
    uint16_t kept = 0;
    for (uint16_t k = 0; k < list->count[i]; k++) {
      const int64_t other = (int64_t)boundary->wall[row[k] / sizeof(hc_record)];
      if (find(moving, other) == own) row[kept++] = row[k];
    }
    for (uint32_t k = kept; k < (list->start[i + 1] - list->start[i]) * HC_LIST_GROUP; k++)
      row[k] = (uint32_t)((size_t)i * sizeof(hc_record));
    list->pairs -= list->count[i] - kept;
    list->count[i] = kept;
  }
}
