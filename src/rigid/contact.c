#include "contact.h"

#include "base/memory.h"
#include "geometry/vector.h"
#include "particles/ids.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double BESIDE = 0.75; /* spacings: how far beside a sample its plane reaches */
static const double AHEAD = 0.25;  /* spacings: what is nearer is looked at, beside what comes in a step */
static const double SLACK = 0.01;  /* spacings: as deep as things may rest */
static const double LET_OUT = 0.2; /* of what is deeper than that, a step; */
static const double FASTEST = 0.1; /* spacings a step: no faster than this */
static const double BOUNCE = 4.0;  /* steps of falling: who comes in faster bounces */
static const double DONE = 1e-6;   /* of a spacing a step: changes so small end the solve */

enum { DIRECTIONS = 26, KEYS = DIRECTIONS + 1, SIDES = 6, PASSES = 200 };

/* A sample of a body in contact. Zeroed before it is filled: points are sent as bytes. */
typedef struct point {
  int32_t body, other;  /* numbers of surfaces */
  int32_t side, unused; /* of the normal */
  uint64_t id;          /* the sample's */
  double arm[3];        /* m: from the body's centre of mass to the place of contact */
  double normal[3];     /* from the other to the body */
  double velocity[3];   /* m/s: of the other there, unless it is a body */
  double gap;           /* m: negative if they overlap */
} point;

typedef struct points {
  point *at;
  size_t count, room;
} points;

/* Who finds the points. */
typedef struct finder {
  const hc_bodies *bodies;
  const hc_world *world;
  double spacing, dt; /* m, s */
} finder;

/* ---- which samples touch ---- */

static int side_of(const double normal[3]) {
  int along = 0;
  for (int axis = 1; axis < 3; axis++)
    if (fabs(normal[axis]) > fabs(normal[along])) along = axis;
  return 2 * along + (normal[along] < 0.0);
}

/* From sample b to sample a, m. */
static void between(const finder *f, const hc_record *a, const hc_record *b, double d[3]) {
  for (int axis = 0; axis < 3; axis++)
    d[axis] = (double)(int32_t)((uint32_t)a->x[axis] - (uint32_t)b->x[axis]) * f->world->frame.unit[axis];
}

/* The gap between the surface behind sample a and that of sample b of another thing, and its normal; false if
 * the two cannot touch. Walls of containers are as thick behind as in front. */
static bool meet(const finder *f, const hc_record *a, int32_t b, double normal[3], double *gap) {
  const hc_particles *const boundary = f->world->boundary;
  const hc_record *const facing = boundary->facing ? &boundary->facing[b] : NULL;
  double d[3];
  between(f, a, &boundary->place[b], d);
  const double square = hc_vector_dot(d, d);
  if (facing && signbit(facing->scalar)) return false; /* an inner edge: its faces speak for it */
  if (facing && facing->scalar == 1.0f) {
    const double n[3] = {(double)facing->v[0], (double)facing->v[1], (double)facing->v[2]},
                 height = hc_vector_dot(d, n), beside = square - height * height;
    for (int axis = 0; axis < 3; axis++) normal[axis] = height < 0.0 ? -n[axis] : n[axis];
    *gap = fabs(height) - f->spacing;
    return beside <= BESIDE * BESIDE * f->spacing * f->spacing;
  }
  const double length = sqrt(square);
  for (int axis = 0; axis < 3; axis++) normal[axis] = d[axis] / length;
  *gap = length - f->spacing;
  return length > 0.0;
}

static bool is_first(const point *a, const point *b) {
  if (a->gap != b->gap) return a->gap < b->gap;
  return memcmp(a->normal, b->normal, sizeof a->normal) < 0;
}

/* The nearest of another thing to a sample, by side of it: at most SIDES for each thing. */
static void note_nearest(points *nearest, const point *found) {
  for (size_t k = 0; k < nearest->count; k++) {
    point *const other = &nearest->at[k];
    if (other->other != found->other || other->side != found->side) continue;
    if (is_first(found, other)) *other = *found;
    return;
  }
  hc_reserve((void **)&nearest->at, &nearest->room, 2 * nearest->count + 8, nearest->count,
             sizeof *nearest->at);
  nearest->at[nearest->count++] = *found;
}

/* Does sample k of a body touch anything? `row`: of the list of what is around. */
static void look_at(finder *f, const hc_body *body, int32_t k, int32_t row, points *nearest) {
  const hc_particles *const moving = f->world->moving, *const boundary = f->world->boundary;
  const hc_neighbors *const list = &f->bodies->touching.moving.list;
  const uint32_t *const offset = hc_list_row(list, row);
  double arm[3], own[3];
  hc_body_arm(f->bodies, body, &moving->position[3 * (size_t)k], arm);
  hc_twist_at(&body->shown, arm, own);
  for (int32_t n = 0; n < hc_list_count(list, row); n++) {
    const int32_t b = (int32_t)(offset[n] / sizeof(hc_record));
    const int32_t other = (int32_t)boundary->motion[b].scalar;
    if (other == body->wall) continue;
    point found;
    memset(&found, 0, sizeof found);
    if (!meet(f, &moving->place[k], b, found.normal, &found.gap)) continue;
    const hc_body *const theirs = hc_bodies_of(f->bodies, other);
    double velocity[3], approach = 0.0;
    if (theirs) {
      double there[3];
      hc_body_arm(f->bodies, theirs, &moving->position[3 * (size_t)k], there);
      hc_twist_at(&theirs->shown, there, velocity);
    }
    for (int axis = 0; axis < 3; axis++) {
      if (!theirs) velocity[axis] = found.velocity[axis] = (double)boundary->motion[b].v[axis];
      approach -= (own[axis] - velocity[axis]) * found.normal[axis];
      found.arm[axis] = arm[axis] - 0.5 * f->spacing * found.normal[axis];
    }
    if (found.gap > AHEAD * f->spacing + fmax(0.0, 2.0 * approach * f->dt)) continue;
    found.body = body->wall;
    found.other = other;
    found.side = side_of(found.normal);
    found.id = moving->id[k];
    note_nearest(nearest, &found);
  }
}

/* ---- few that stand for all ---- */

/* What touches one thing on one side, by those that stand for it: of each key the best. */
typedef struct patch {
  point best[KEYS];
} patch;

typedef struct patches {
  patch *at; /* ascending */
  size_t count, room;
} patches;

static double rank_of(const point *touching, int key) {
  if (key == DIRECTIONS) return -touching->gap;
  const int number = key < DIRECTIONS / 2 ? key : key + 1; /* the middle of 27 is none */
  return (number % 3 - 1) * touching->arm[0] + (number / 3 % 3 - 1) * touching->arm[1] +
         (number / 9 - 1) * touching->arm[2];
}

static int compare_places(const point *a, const point *b) {
  if (a->body != b->body) return a->body < b->body ? -1 : 1;
  if (a->other != b->other) return a->other < b->other ? -1 : 1;
  return (a->side > b->side) - (a->side < b->side);
}

/* The patch of a point; a new one has nothing but it. */
static patch *patch_of(patches *patches, const point *touching) {
  size_t low = 0, high = patches->count;
  while (low < high) {
    const size_t middle = low + (high - low) / 2;
    if (compare_places(&patches->at[middle].best[0], touching) < 0)
      low = middle + 1;
    else
      high = middle;
  }
  if (low < patches->count && compare_places(&patches->at[low].best[0], touching) == 0)
    return &patches->at[low];
  hc_reserve((void **)&patches->at, &patches->room, 2 * patches->count + 4, patches->count,
             sizeof *patches->at);
  memmove(&patches->at[low + 1], &patches->at[low], (patches->count - low) * sizeof *patches->at);
  patches->count++;
  for (int key = 0; key < KEYS; key++) patches->at[low].best[key] = *touching;
  return &patches->at[low];
}

/* The farther is the better, then the lower id. */
static void enter(patches *patches, const point *touching) {
  patch *const patch = patch_of(patches, touching);
  for (int key = 0; key < KEYS; key++) {
    const double now = rank_of(&patch->best[key], key), then = rank_of(touching, key);
    if (then > now || (!(then < now) && touching->id < patch->best[key].id)) patch->best[key] = *touching;
  }
}

/* The points of all patches, each sample of a patch once. */
static void list_points(const patches *patches, points *list) {
  list->count = 0;
  hc_reserve((void **)&list->at, &list->room, KEYS * patches->count + 1, 0, sizeof *list->at);
  for (size_t k = 0; k < patches->count; k++) {
    const size_t first = list->count;
    for (int key = 0; key < KEYS; key++) {
      const point *const best = &patches->at[k].best[key];
      size_t same = first;
      while (same < list->count && list->at[same].id != best->id) same++;
      if (same == list->count) list->at[list->count++] = *best;
    }
  }
}

/* The points of all ranks, the same on each, in an order of their own. */
static points find_points(hc_bodies *bodies, hc_world *world, double spacing, double dt) {
  finder f = {bodies, world, spacing, dt};
  hc_particles *const moving = world->moving;
  points nearest = {.count = 0}, list = {.count = 0};
  patches found = {.count = 0};
  const hc_touching_side *const side = &bodies->touching.moving;
  for (int32_t row = 0; row < side->count; row++) {
    const int32_t k = side->index[row];
    const hc_body *const body = hc_bodies_of(bodies, (int)hc_id_source_of(moving->id[k]));
    if (!body) continue;
    nearest.count = 0;
    look_at(&f, body, k, row, &nearest);
    for (size_t n = 0; n < nearest.count; n++) enter(&found, &nearest.at[n]);
  }
  list_points(&found, &list);
  point *all;
  size_t bytes;
  hc_comm_gather_all(world->comm, list.at, list.count * sizeof *list.at, (void **)&all, &bytes);
  found.count = 0;
  for (size_t n = 0; n < bytes / sizeof *all; n++) enter(&found, &all[n]);
  list_points(&found, &list);
  hc_free(all);
  hc_free(nearest.at);
  hc_free(found.at);
  return list;
}

/* ---- impulses ---- */

/* A contact while it is solved: along the normal and two tangents. */
typedef struct contact {
  hc_body *body, *other; /* null other: a wall */
  double arm[3], other_arm[3], velocity[3];
  double axis[3][3];
  double mass[3]; /* kg: effective */
  double least;   /* m/s: of the relative speed along the normal */
  double impulse[3], friction;
} contact;

/* What an impulse of 1 at the arm along an axis changes the speed there by. */
static double yielding(const hc_body *body, const double arm[3], const double axis[3]) {
  double moment[3], sum = 0.0;
  hc_vector_cross(arm, axis, moment);
  for (int a = 0; a < 3; a++) {
    if (!(body->locked >> a & 1)) sum += axis[a] * axis[a] / body->mass;
    sum += moment[a] * hc_vector_dot(body->compliance[a], moment);
  }
  return sum;
}

static void relative(const contact *c, double velocity[3]) {
  hc_twist_at(&c->body->shown, c->arm, velocity);
  double theirs[3];
  if (c->other)
    hc_twist_at(&c->other->shown, c->other_arm, theirs);
  else
    memcpy(theirs, c->velocity, sizeof theirs);
  for (int a = 0; a < 3; a++) velocity[a] -= theirs[a];
}

static void apply(contact *c, int axis, double impulse) {
  double linear[3], opposite[3];
  for (int a = 0; a < 3; a++) {
    linear[a] = impulse * c->axis[axis][a];
    opposite[a] = -linear[a];
  }
  hc_twist twist = {.linear = {0.0, 0.0, 0.0}}, back = {.linear = {0.0, 0.0, 0.0}};
  hc_twist_add_at(&twist, c->arm, linear);
  hc_body_push_shown(c->body, &twist);
  hc_body_push(c->body, &twist);
  if (!c->other) return;
  hc_twist_add_at(&back, c->other_arm, opposite);
  hc_body_push_shown(c->other, &back);
  hc_body_push(c->other, &back);
}

/* Changes the impulse along an axis to within [low, high]; returns by how much the speed changed. */
static double change(contact *c, int axis, double wanted, double low, double high) {
  double velocity[3];
  relative(c, velocity);
  const double before = c->impulse[axis], speed = hc_vector_dot(velocity, c->axis[axis]);
  if (c->mass[axis] == 0.0) return 0.0;
  c->impulse[axis] = fmin(fmax(before + c->mass[axis] * (wanted - speed), low), high);
  const double impulse = c->impulse[axis] - before;
  if (impulse != 0.0) apply(c, axis, impulse);
  return fabs(impulse / c->mass[axis]);
}

static void tangents(contact *c) {
  int least = 0;
  for (int a = 1; a < 3; a++)
    if (fabs(c->axis[0][a]) < fabs(c->axis[0][least])) least = a;
  double along[3] = {0.0, 0.0, 0.0};
  along[least] = 1.0;
  hc_vector_cross(c->axis[0], along, c->axis[1]);
  hc_vector_normalize(c->axis[1]);
  hc_vector_cross(c->axis[0], c->axis[1], c->axis[2]);
}

static contact make(const hc_bodies *bodies, const point *point, double spacing, double dt) {
  contact c = {.body = hc_bodies_of(bodies, point->body), .other = hc_bodies_of(bodies, point->other)};
  memcpy(c.arm, point->arm, sizeof c.arm);
  memcpy(c.velocity, point->velocity, sizeof c.velocity);
  memcpy(c.axis[0], point->normal, sizeof c.axis[0]);
  tangents(&c);
  if (c.other) {
    int64_t at[3];
    for (int a = 0; a < 3; a++) at[a] = c.body->position[a] + llrint(c.arm[a] / bodies->frame->unit[a]);
    hc_body_arm(bodies, c.other, at, c.other_arm);
  }
  for (int axis = 0; axis < 3; axis++) {
    const double sum = yielding(c.body, c.arm, c.axis[axis]) +
                       (c.other ? yielding(c.other, c.other_arm, c.axis[axis]) : 0.0);
    c.mass[axis] = sum > 0.0 ? 1.0 / sum : 0.0;
  }
  c.friction = c.other ? sqrt(c.body->friction * c.other->friction) : c.body->friction;
  const double bounces = c.other ? fmax(c.body->restitution, c.other->restitution) : c.body->restitution;
  double velocity[3];
  relative(&c, velocity);
  const hc_twist pull = hc_body_pull(bodies, c.body);
  const double speed = hc_vector_dot(velocity, c.axis[0]), pulled = hc_vector_length(pull.linear);
  const double fall = fmax(hc_vector_length(bodies->gravity), pulled / c.body->mass) * dt;
  const double deep = fmin(0.0, point->gap + SLACK * spacing);
  c.least = point->gap > 0.0 ? -point->gap / dt : fmin(-LET_OUT * deep, FASTEST * spacing) / dt;
  if (bounces > 0.0 && speed < -BOUNCE * fall && speed < c.least) c.least = -bounces * speed;
  return c;
}

static void solve(contact *contacts, size_t count, double enough) {
  for (int pass = 0; pass < PASSES; pass++) {
    double largest = 0.0;
    for (size_t k = 0; k < count; k++) {
      contact *const c = &contacts[k];
      largest = fmax(largest, change(c, 0, c->least, 0.0, INFINITY));
      const double most = c->friction * c->impulse[0];
      for (int axis = 1; axis < 3; axis++) largest = fmax(largest, change(c, axis, 0.0, -most, most));
    }
    if (largest <= enough) break;
  }
}

void hc_contact_resolve(hc_bodies *bodies, hc_world *world, double dt) {
  if (bodies->count == 0) return;
  for (int k = 0; k < bodies->count; k++) { /* with what is known of their velocities by now */
    hc_body *const body = &bodies->body[k];
    memcpy(body->shown.linear, body->velocity, sizeof body->shown.linear);
    hc_body_spin(body, body->shown.angular);
  }
  if (!bodies->touching.any) return;
  const double spacing = 2.0 * (double)world->sweep.wall_offset * (double)world->sweep.support;
  points found = find_points(bodies, world, spacing, dt);
  contact *const contacts = hc_alloc(found.count, sizeof *contacts);
  for (size_t k = 0; k < found.count; k++) contacts[k] = make(bodies, &found.at[k], spacing, dt);
  solve(contacts, found.count, DONE * spacing / dt);
  hc_free(contacts);
  hc_free(found.at);
}
