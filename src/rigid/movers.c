#include "movers.h"

#include "base/check.h"
#include "base/memory.h"
#include "particles/ids.h"

#include <math.h>
#include <string.h>

void hc_movers_init(hc_movers *movers, int count, int rows) {
  *movers = (hc_movers){.walls = hc_alloc_zero((size_t)count, sizeof *movers->walls),
                        .rows = hc_alloc_zero((size_t)rows, sizeof *movers->rows),
                        .poses = hc_alloc_zero((size_t)count, sizeof *movers->poses),
                        .count = count};
}

void hc_movers_free(hc_movers *movers) {
  hc_free(movers->walls);
  hc_free(movers->rows);
  hc_free(movers->poses);
  memset(movers, 0, sizeof *movers);
}

double hc_mover_speed(const hc_mover *wall, double time, double ahead) {
  if (wall->motion.law == HC_MOTION_BODY) return hc_pose_speed(&wall->given, wall->reach);
  const hc_pose now = hc_motion_pose(&wall->motion, time), then = hc_motion_pose(&wall->motion, time + ahead);
  return fmax(hc_pose_speed(&now, wall->reach), hc_pose_speed(&then, wall->reach));
}

/* The poses, and the largest speed of any sample. */
static double evaluate(const hc_movers *moving, double time, double ahead, bool held, hc_pose *poses) {
  double speed = 0.0;
  for (int k = 0; k < moving->count; k++) {
    const hc_mover *wall = &moving->walls[k];
    speed = fmax(speed, hc_mover_speed(wall, time, ahead));
    poses[k] = wall->motion.law == HC_MOTION_BODY ? wall->given : hc_motion_pose(&wall->motion, time);
    if (!held) continue;
    memset(poses[k].velocity, 0, sizeof poses[k].velocity);
    memset(poses[k].spin, 0, sizeof poses[k].spin);
  }
  return speed;
}

static bool is_moving(const hc_pose *pose) {
  return hc_pose_speed(pose, 1.0) > 0.0;
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
    boundary->position[3 * (size_t)k + (size_t)a] =
        hc_frame_wrap(frame, a, reference[a] + pose->units[a] + units);
    boundary->normal[3 * (size_t)k + (size_t)a] = (float)(v[a] + leant[a]);
  }
}

void hc_movers_start(hc_particles *moving) {
  memcpy(moving->reference_normal, moving->normal, 3 * (size_t)moving->own * sizeof *moving->normal);
}

/* What is at that arm, as it points now, has the velocity v + spin x arm. */
static void velocity_at(const hc_pose *pose, const double arm[3], double velocity[3]) {
  for (int a = 0; a < 3; a++) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    velocity[a] = pose->velocity[a] + (pose->spin[b] * arm[c] - pose->spin[c] * arm[b]);
  }
}

static void drive(const hc_frame *frame, const hc_motion *motion, const hc_pose *pose, hc_particles *boundary,
                  int32_t k) {
  double arm[3], added[3], velocity[3];
  arm_of(frame, motion, &boundary->reference[3 * (size_t)k], arm);
  turned(pose, arm, added);
  for (int a = 0; a < 3; a++) arm[a] += added[a];
  velocity_at(pose, arm, velocity);
  for (int a = 0; a < 3; a++) boundary->wall_velocity[3 * (size_t)k + (size_t)a] = (float)velocity[a];
}

void hc_movers_carry(const hc_movers *movers, const hc_frame *frame, int wall, double ahead, double x[3],
                     double direction[3]) {
  const int found = find(movers, wall);
  if (found < 0) return;
  const hc_pose *const pose = &movers->poses[found];
  const double *const centre = movers->walls[found].motion.centre;
  double arm[3], added[3], velocity[3];
  for (int a = 0; a < 3; a++) arm[a] = x[a] - centre[a];
  turned(pose, arm, added);
  for (int a = 0; a < 3; a++) arm[a] += added[a];
  velocity_at(pose, arm, velocity);
  for (int a = 0; a < 3; a++)
    x[a] =
        centre[a] + arm[a] + pose->shift[a] + (double)pose->units[a] * frame->unit[a] + ahead * velocity[a];
  turned(pose, direction, added);
  for (int a = 0; a < 3; a++) direction[a] += added[a];
}

void hc_movers_place(const hc_movers *movers, const hc_frame *frame, hc_particles *moving) {
  finder finder = {movers, -1, -1};
  for (int32_t k = 0; k < moving->own; k++) {
    const int found = find_next(&finder, hc_id_source_of(moving->id[k]));
    HC_CHECK(found >= 0, "sample %llu belongs to no wall that moves", (unsigned long long)moving->id[k]);
    place(frame, &movers->walls[found].motion, &movers->poses[found], moving, k);
    drive(frame, &movers->walls[found].motion, &movers->poses[found], moving, k);
  }
}

void hc_movers_pose(hc_movers *movers, hc_world *world, double time, double ahead, bool held) {
  if (movers->count == 0 || (movers->posed && movers->time == time && !held)) return;
  /* the poses, and behind them the largest speed in a pose of its own */
  const size_t count = (size_t)movers->count, bytes = (count + 1) * sizeof(hc_pose);
  hc_pose *poses = hc_alloc_zero(count + 1, sizeof *poses);
  if (world->comm->rank == 0) poses[count].shift[0] = evaluate(movers, time, ahead, held, poses);
  hc_comm_broadcast(world->comm, poses, bytes, 0);
  const bool changed = memcmp(poses, movers->poses, count * sizeof *poses) != 0;
  memcpy(movers->poses, poses, count * sizeof *poses);
  movers->speed = poses[count].shift[0];
  hc_free(poses);
  movers->time = time;
  movers->posed = !held; /* what was held back is asked for again */
  world->sweep.walls_move = false;
  for (int k = 0; k < movers->count; k++) /* bodies yield from rest, too */
    world->sweep.walls_move |=
        is_moving(&movers->poses[k]) || (!held && movers->walls[k].motion.law == HC_MOTION_BODY);
  if (!changed) return;
  hc_movers_place(movers, &world->frame, world->moving);
  world->stores[HC_STORE_MOVING].moved = true;
}
