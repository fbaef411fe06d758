/* Each sample of a wall takes the force of its pairs with particles, but for what of it goes along its face:
 * that belongs to a wall across which it goes, as what pushes the foot of a box on a floor down. So of each
 * particle what goes along faces is added up, to T, and so is what contact took, and shared out along
 * normals: F_b = w_b (n_b (n_b.l) + e l), with l such that they add up to T. w_b = 1 - r/h of the samples in
 * front of which the particle is. At outer edges samples keep the force of their pairs; those of inner edges
 * have no face of their own and keep nothing. */
#include "wall_force.h"

#include "base/memory.h"
#include "geometry/vector.h"
#include "sph/kernel.h"
#include "wall_drag.h"
#include "wall_layer.h"
#include "wall_weight.h"

#include <math.h>
#include <string.h>

enum { BATCH = 32 }; /* particles that are looked at together, whether a wanted wall is near any */

static const double ASIDE = 0.02; /* e: of a share, what goes along the wall */

/* A particle and a sample: from the sample on, in support radii; and what is found of the two. */
typedef struct pair {
  int32_t b;
  double d[3], q;
  double force[3], aside[3]; /* N, of pressure on the sample: what stays there, what goes along its face */
  double rubs;               /* share in friction */
} pair;

static double along(const float normal[3], const double v[3]) {
  return (double)normal[0] * v[0] + (double)normal[1] * v[1] + (double)normal[2] * v[2];
}

/* ---- what a particle puts on walls ---- */

/* A particle and its walls. */
typedef struct pusher {
  const hc_sweep *sweep;
  int32_t i;
  pair *pairs;
  int32_t count;
  double squared[3];    /* N/D_0, see hc_wall_weight */
  const float *contact; /* null: none */
  const hc_touch *touch;
  bool any;    /* in front of no face: all samples share alike */
  double l[3]; /* see above */
  double rubs; /* sum of the shares in friction */
  bool alone;  /* all samples are of one wall */
} pusher;

/* Its pairs within the support radius; lists may reach further. `room` for all of the list. */
static void find_pairs(pusher *p, pair *room) {
  const hc_sweep *const sweep = p->sweep;
  const uint32_t *const offset = hc_list_row(sweep->walls, p->i);
  const hc_record *const walls = sweep->boundary->motion;
  const double scale = hc_wall_weight_scale(sweep);
  p->pairs = room;
  p->alone = true;
  for (int32_t k = 0; k < hc_list_count(sweep->walls, p->i); k++) {
    pair *const pair = &room[p->count];
    pair->b = (int32_t)(offset[k] / sizeof(hc_record));
    hc_sweep_from_wall(sweep, p->i, pair->b, pair->d);
    const double square = hc_vector_dot(pair->d, pair->d);
    if (!(square < 1.0)) continue;
    pair->q = sqrt(square);
    hc_wall_weight_add(sweep, scale, pair->b, pair->q, p->squared);
    p->alone &= walls[pair->b].scalar == walls[room->b].scalar;
    p->count++;
  }
}

/* The pressure that a particle pushes with. */
static double push_of(const hc_sweep *sweep, int32_t i) {
  const double relative =
      sweep->compressible ? (double)sweep->fluid->density[i] / (double)sweep->rest_density : 1.0;
  return (double)sweep->fluid->pressure[i] / (relative * relative);
}

/* What of a particle's pressure and a sample's acts between them, by how walls take part: times m/rho0 grad W
 * a force. */
static double strength(const hc_sweep *sweep, int32_t i, const pair *pair, const double squared[3],
                       const hc_touch *touch) {
  const hc_particles *fluid = sweep->fluid, *boundary = sweep->boundary;
  switch (sweep->walls_add) {
  case HC_WALLS_MIRRORED: {
    const double weight = hc_wall_weight(sweep, pair->b, squared);
    double depth = 0.0;
    if (touch) depth = -(double)sweep->rest_density * (double)sweep->support * along(touch->depth, pair->d);
    return (push_of(sweep, i) * weight + depth) * (double)boundary->place[pair->b].scalar;
  }
  case HC_WALLS_PRESSURE:
    return (double)sweep->rest_density * sweep->volume *
           ((double)fluid->place[i].scalar + (double)boundary->place[pair->b].scalar);
  case HC_WALLS_NOTHING:
  case HC_WALLS_DISTANCE:
    break;
  }
  return 0.0;
}

/* What contact with walls has changed a particle's velocity by; null: nothing. `next`: the holds before are
 * those of particles before. */
static const float *contact_of(const hc_sweep *sweep, int32_t i, size_t *next) {
  if (sweep->contacts) return sweep->contacts[i].v;
  const hc_holds *const holds = sweep->holds;
  while (holds && *next < holds->count && holds->at[*next].particle < i) ++*next;
  return holds && *next < holds->count && holds->at[*next].particle == i ? holds->at[*next].change : NULL;
}

/* What friction and depth did beside the pressure; null: nothing. */
static const hc_touch *touch_of(const hc_sweep *sweep, int32_t i, size_t *next) {
  const hc_touches *const touches = sweep->touches;
  while (touches && *next < touches->count && touches->at[*next].particle < i) ++*next;
  return touches && *next < touches->count && touches->at[*next].particle == i ? &touches->at[*next] : NULL;
}

/* Is the sample of a face, with a normal? */
static bool is_face(const hc_sweep *sweep, int32_t b) {
  const hc_record *const facing = &sweep->boundary->facing[b];
  return facing->scalar == 1.0f && (facing->v[0] != 0.0f || facing->v[1] != 0.0f || facing->v[2] != 0.0f);
}

/* The force of a pair, over d. */
static double factor_of(const pusher *p, const pair *pair) {
  const hc_sweep *const sweep = p->sweep;
  return strength(sweep, p->i, pair, p->squared, p->touch) * sweep->volume * sweep->gradient *
         hc_kernel_slope_over_q(pair->q);
}

/* The force of a pair on its sample, and what of it goes along the face. */
static void pair_force(const pusher *p, pair *pair) {
  const hc_sweep *const sweep = p->sweep;
  double *const force = pair->force, *const aside = pair->aside, factor = factor_of(p, pair);
  for (int axis = 0; axis < 3; axis++) {
    force[axis] = factor * pair->d[axis];
    aside[axis] = 0.0;
  }
  if (signbit(sweep->boundary->facing[pair->b].scalar)) { /* an inner edge: all of it belongs to the faces */
    memcpy(aside, force, sizeof pair->aside);
    memset(force, 0, sizeof pair->force);
  }
  if (!is_face(sweep, pair->b)) return;
  const float *const n = sweep->boundary->facing[pair->b].v;
  const double across = along(n, force);
  for (int axis = 0; axis < 3; axis++) {
    aside[axis] = force[axis] - across * (double)n[axis];
    force[axis] = across * (double)n[axis];
  }
}

/* ---- who takes what goes along ---- */

/* The weight of a sample in the sharing. */
static double weight_of(const pusher *p, const pair *pair) {
  const float *const n = p->sweep->boundary->facing[pair->b].v;
  const bool takes = p->any || (is_face(p->sweep, pair->b) && along(n, pair->d) > 0.0);
  return takes ? 1.0 - pair->q : 0.0;
}

/* Solves m x = b for symmetric positive definite m: xx, yy, zz, xy, xz, yz. */
static void solve(const double m[6], const double b[3], double x[3]) {
  const double xx = m[1] * m[2] - m[5] * m[5], yy = m[0] * m[2] - m[4] * m[4], zz = m[0] * m[1] - m[3] * m[3],
               xy = m[4] * m[5] - m[3] * m[2], xz = m[3] * m[5] - m[4] * m[1], yz = m[3] * m[4] - m[0] * m[5];
  const double whole = m[0] * xx + m[3] * xy + m[4] * xz;
  x[0] = (xx * b[0] + xy * b[1] + xz * b[2]) / whole;
  x[1] = (xy * b[0] + yy * b[1] + yz * b[2]) / whole;
  x[2] = (xz * b[0] + yz * b[1] + zz * b[2]) / whole;
}

/* Finds l for T, from the samples around. */
static bool find_sharing(pusher *p, const double aside[3]) {
  double m[6] = {0.0}, sum = 0.0;
  for (int32_t k = 0; k < p->count; k++) {
    const pair *const pair = &p->pairs[k];
    const double weight = weight_of(p, pair);
    if (!(weight > 0.0)) continue;
    double n[3] = {0.0, 0.0, 0.0};
    for (int axis = 0; axis < 3 && !p->any; axis++)
      n[axis] = (double)p->sweep->boundary->facing[pair->b].v[axis];
    sum += weight;
    for (int axis = 0; axis < 3; axis++) m[axis] += weight * (n[axis] * n[axis] + ASIDE);
    m[3] += weight * n[0] * n[1];
    m[4] += weight * n[0] * n[2];
    m[5] += weight * n[1] * n[2];
  }
  if (!(sum > 0.0)) return false;
  for (int k = 0; k < 6; k++) m[k] /= sum; /* keeps their products in range */
  solve(m, aside, p->l);
  for (int axis = 0; axis < 3; axis++) p->l[axis] /= sum;
  return true;
}

/* What a change of the particle's velocity by 1 m/s takes from it, N. */
static double per_change(const pusher *p, double dt) {
  return -(double)p->sweep->rest_density * p->sweep->volume / dt;
}

static bool is_zero(const double v[3]) {
  return v[0] == 0.0 && v[1] == 0.0 && v[2] == 0.0;
}

/* Looks at all pairs of the particle; false: its pressure, contact and friction push nothing. */
static bool look_at_pairs(pusher *p, double dt) {
  const hc_sweep *const sweep = p->sweep;
  const double of_change = per_change(p, dt);
  double sum[3] = {0.0, 0.0, 0.0};
  bool pushes = false;
  for (int axis = 0; axis < 3 && p->contact; axis++) sum[axis] = of_change * (double)p->contact[axis];
  for (int32_t k = 0; k < p->count; k++) {
    pair *const pair = &p->pairs[k];
    pair_force(p, pair);
    pair->rubs = p->touch ? hc_wall_layer_share(sweep, pair->d, pair->b) : 0.0;
    p->rubs += pair->rubs;
    for (int axis = 0; axis < 3; axis++) {
      sum[axis] += pair->aside[axis];
      pushes |= pair->force[axis] != 0.0;
    }
  }
  if (is_zero(sum)) return pushes || p->touch;
  if (find_sharing(p, sum)) return true;
  p->any = true;
  return find_sharing(p, sum);
}

/* ---- both together ---- */

double hc_wall_force_later(const hc_sweep *sweep, double dt) {
  return sweep->contacts ? dt : 0.0;
}

/* The step whose pushes are shown, and to whom. */
typedef struct show {
  const hc_frame *frame;
  double dt, back; /* s: back: how long particles have moved since they were where their records say */
  hc_wall_push_taker take;
  void *context;
} show;

/* A push of the particle on nothing yet. `metres`: of what is in support radii. */
static hc_wall_push start_push(const pusher *p, const show *show, double metres[3]) {
  const hc_sweep *const sweep = p->sweep;
  const hc_particles *const fluid = sweep->fluid;
  hc_wall_push push = {.particle = p->i};
  for (int axis = 0; axis < 3; axis++) {
    const size_t at = 3 * (size_t)p->i + (size_t)axis;
    push.by[axis] =
        hc_frame_to_metres(show->frame, axis, fluid->position[at]) - show->back * (double)fluid->velocity[at];
    metres[axis] = show->frame->unit[axis] / sweep->scale[axis];
  }
  return push;
}

static void share_out(const pusher *p, const hc_dragger *drag, const show *show) {
  const hc_sweep *const sweep = p->sweep;
  const double of_rub = p->rubs > 0.0 ? per_change(p, show->dt) / p->rubs : 0.0;
  double metres[3];
  hc_wall_push push = start_push(p, show, metres);
  for (int32_t k = 0; k < p->count; k++) {
    const pair *const pair = &p->pairs[k];
    const float *const n = sweep->boundary->facing[pair->b].v;
    const double weight = weight_of(p, pair), push_along = p->any ? 0.0 : along(n, p->l),
                 rub = of_rub * pair->rubs;
    double dragged[3];
    push.wall = (int)sweep->boundary->motion[pair->b].scalar;
    hc_wall_drag_on(sweep, drag, pair->b, pair->d, pair->q, dragged);
    for (int axis = 0; axis < 3; axis++) {
      push.from[axis] = pair->d[axis] * metres[axis];
      push.force[axis] = pair->force[axis] + dragged[axis];
      if (weight > 0.0) push.force[axis] += weight * ((double)n[axis] * push_along + ASIDE * p->l[axis]);
      if (rub != 0.0) push.force[axis] += rub * (double)p->touch->rub[axis];
    }
    if (is_zero(push.force)) continue;
    hc_vector_cross(push.force, push.from, push.moment); /* the sample is at -from */
    show->take(show->context, &push);
  }
}

/* Where one wall takes all: pressures act along the line to the particle, so they have no moment about it;
 * contacts act on the particle. */
static void push_at_once(const pusher *p, const hc_dragger *drag, const show *show) {
  const hc_sweep *const sweep = p->sweep;
  const double of_change = per_change(p, show->dt);
  double metres[3], rubs = 0.0, rubbed[3] = {0.0};
  hc_wall_push push = start_push(p, show, metres);
  push.wall = (int)sweep->boundary->motion[p->pairs->b].scalar;
  for (int axis = 0; axis < 3 && p->contact; axis++) push.force[axis] = of_change * (double)p->contact[axis];
  for (int32_t k = 0; k < p->count; k++) {
    const pair *const pair = &p->pairs[k];
    const double factor = factor_of(p, pair),
                 rub = p->touch ? hc_wall_layer_share(sweep, pair->d, pair->b) : 0.0;
    double dragged[3];
    hc_wall_drag_on(sweep, drag, pair->b, pair->d, pair->q, dragged);
    rubs += rub;
    for (int axis = 0; axis < 3; axis++) {
      const int b = (axis + 1) % 3, c = (axis + 2) % 3;
      push.force[axis] += factor * pair->d[axis] + dragged[axis];
      push.moment[axis] += dragged[b] * pair->d[c] * metres[c] - dragged[c] * pair->d[b] * metres[b];
      rubbed[axis] += rub * pair->d[axis] * metres[axis];
    }
  }
  if (rubs > 0.0) {
    double rub[3], moment[3];
    for (int axis = 0; axis < 3; axis++) {
      rub[axis] = of_change * (double)p->touch->rub[axis];
      rubbed[axis] /= rubs;
      push.force[axis] += rub[axis];
    }
    hc_vector_cross(rub, rubbed, moment);
    for (int axis = 0; axis < 3; axis++) push.moment[axis] += moment[axis];
  }
  if (!is_zero(push.force)) show->take(show->context, &push);
}

/* The wanted walls, and the first record that may be of one. */
typedef struct wanted_walls {
  const bool *wall;
  uint32_t first;
} wanted_walls;

/* Where only what moves is wanted, what stands still need not be looked at, as most of it is. */
static wanted_walls look_for(const hc_sweep *sweep, const bool *wall) {
  const hc_particles *const still = sweep->boundary;
  int32_t first = 0;
  while (still->tail && first < still->own + still->ghosts && !wall[(int)still->motion[first].scalar])
    first++;
  return (wanted_walls){wall, (uint32_t)((size_t)first * sizeof(hc_record))};
}

/* Is any wall near the particle one of those? */
static bool any_wanted(const hc_sweep *sweep, int32_t i, const wanted_walls *wanted) {
  const uint32_t *const offset = hc_list_row(sweep->walls, i);
  const int32_t count = hc_list_count(sweep->walls, i);
  bool any = false;
  for (int32_t k = 0; k < count && !any; k++)
    any = offset[k] >= wanted->first &&
          wanted->wall[(int)sweep->boundary->motion[offset[k] / sizeof(hc_record)].scalar];
  return any;
}

/* Could any be near particles [begin, end)? */
static bool any_behind(const hc_neighbors *list, int32_t begin, int32_t end, uint32_t first) {
  uint32_t any = 0;
  for (uint32_t k = hc_list_begin(list, begin); k < hc_list_begin(list, end); k++)
    any |= list->offset[k] >= first;
  return any;
}

void hc_wall_force_each(const hc_sweep *sweep, const hc_frame *frame, double dt, const bool *wanted,
                        bool at_once, hc_wall_push_taker take, void *context) {
  const show show = {frame, dt, dt - hc_wall_force_later(sweep, dt), take, context};
  const wanted_walls walls = look_for(sweep, wanted);
  size_t next_hold = 0, next_touch = 0, room = 0;
  pair *pairs = NULL;
  const int32_t own = sweep->fluid->own;
  for (int32_t i = 0; i < own; i++) {
    if (i % BATCH == 0 && !any_behind(sweep->walls, i, i + BATCH < own ? i + BATCH : own, walls.first)) {
      i += BATCH - 1;
      continue;
    }
    if (!any_wanted(sweep, i, &walls)) continue;
    pusher p = {.sweep = sweep,
                .i = i,
                .contact = contact_of(sweep, i, &next_hold),
                .touch = touch_of(sweep, i, &next_touch)};
    hc_reserve((void **)&pairs, &room, (size_t)hc_list_count(sweep->walls, i) + 1, 0, sizeof *pairs);
    find_pairs(&p, pairs);
    if (p.count == 0) continue;
    const hc_dragger drag = hc_wall_drag_by(sweep, i, dt);
    if (at_once && p.alone)
      push_at_once(&p, &drag, &show);
    else if (look_at_pairs(&p, dt) || drag.factor != 0.0)
      share_out(&p, &drag, &show);
  }
  hc_free(pairs);
}
