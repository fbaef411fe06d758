/* Each sample of a wall takes the force of its pairs with particles, but for what of it goes along its face:
 * that belongs to a wall across which it goes, as what pushes the foot of a box on a floor down. So of each
 * particle what goes along faces is added up, to T, and so is what contact took, and shared out along
 * normals: F_b = w_b (n_b (n_b.l) + e l), with l such that they add up to T. w_b = 1 - r/h of the samples in
 * front of which the particle is. At outer edges samples keep the force of their pairs; those of inner edges
 * have no face of their own and keep nothing. */
#include "wall_force.h"

#include "base/memory.h"
#include "sph/kernel.h"
#include "wall_drag.h"
#include "wall_layer.h"
#include "wall_weight.h"

#include <math.h>
#include <string.h>

static const double ASIDE = 0.02; /* e: of a share, what goes along the wall */

/* A particle and a sample: from the sample on, in support radii; and what is found of the two. */
typedef struct pair {
  int32_t b;
  double d[3], q;
  double force[3], aside[3]; /* N, of pressure on the sample: what stays there, what goes along its face */
  double rubs;               /* share in friction */
} pair;

static pair make_pair(const hc_sweep *sweep, int32_t i, uint32_t offset) {
  pair pair = {.b = (int32_t)(offset / sizeof(hc_record))};
  hc_sweep_from_wall(sweep, i, pair.b, pair.d);
  pair.q = sqrt(pair.d[0] * pair.d[0] + pair.d[1] * pair.d[1] + pair.d[2] * pair.d[2]);
  return pair;
}

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
  double squared[3];    /* see hc_wall_weight_normal */
  const float *contact; /* null: none */
  const hc_touch *touch;
  bool any;    /* in front of no face: all samples share alike */
  double l[3]; /* see above */
  double rubs; /* sum of the shares in friction */
} pusher;

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

/* The force of a pair on its sample. */
static void pair_force(const pusher *p, pair *pair) {
  const hc_sweep *const sweep = p->sweep;
  double *const force = pair->force, *const aside = pair->aside;
  const double factor = pair->q < 1.0 ? strength(sweep, p->i, pair, p->squared, p->touch) * sweep->volume *
                                            sweep->gradient * hc_kernel_slope_over_q(pair->q)
                                      : 0.0;
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
  return takes ? fmax(0.0, 1.0 - pair->q) : 0.0;
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

/* Looks at all pairs of the particle; false: its pressure, contact and friction push nothing. */
static bool look_at_pairs(pusher *p, double dt) {
  const hc_sweep *const sweep = p->sweep;
  const double of_change = -(double)sweep->rest_density * sweep->volume / dt;
  double sum[3] = {0.0, 0.0, 0.0};
  bool pushes = false;
  hc_wall_weight_normal(sweep, p->i, p->squared);
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
  if (sum[0] == 0.0 && sum[1] == 0.0 && sum[2] == 0.0) return pushes || p->touch;
  if (find_sharing(p, sum)) return true;
  p->any = true;
  return find_sharing(p, sum);
}

/* ---- both together ---- */

double hc_wall_force_later(const hc_sweep *sweep, double dt) {
  return sweep->contacts ? dt : 0.0;
}

/* `back`: how long the particle has moved since it was where its record says, s. */
static void share_out(const pusher *p, const hc_dragger *drag, const hc_frame *frame, double back, double dt,
                      hc_wall_push_taker take, void *context) {
  const hc_sweep *const sweep = p->sweep;
  const hc_particles *const fluid = sweep->fluid;
  const size_t at = 3 * (size_t)p->i;
  const double of_rub = p->rubs > 0.0 ? -(double)sweep->rest_density * sweep->volume / dt / p->rubs : 0.0;
  for (int32_t k = 0; k < p->count; k++) {
    const pair *const pair = &p->pairs[k];
    const float *const n = sweep->boundary->facing[pair->b].v;
    const double weight = weight_of(p, pair), push_along = p->any ? 0.0 : along(n, p->l),
                 rub = of_rub * pair->rubs;
    hc_wall_push push = {.wall = (int)sweep->boundary->motion[pair->b].scalar};
    double dragged[3];
    hc_wall_drag_on(sweep, drag, pair->b, pair->d, pair->q, dragged);
    for (int axis = 0; axis < 3; axis++) {
      push.at[axis] = hc_frame_to_metres(frame, axis, fluid->position[at + (size_t)axis]) -
                      back * fluid->velocity[at + (size_t)axis] -
                      pair->d[axis] / sweep->scale[axis] * frame->unit[axis];
      push.from[axis] = pair->d[axis] / sweep->scale[axis] * frame->unit[axis];
      push.force[axis] = pair->force[axis] + dragged[axis];
      if (weight > 0.0) push.force[axis] += weight * ((double)n[axis] * push_along + ASIDE * p->l[axis]);
      if (rub != 0.0) push.force[axis] += rub * (double)p->touch->rub[axis];
    }
    if (push.force[0] != 0.0 || push.force[1] != 0.0 || push.force[2] != 0.0) take(context, &push);
  }
}

/* Is any wall near the particle one of those? */
static bool any_wanted(const hc_sweep *sweep, int32_t i, const bool *wanted) {
  const uint32_t *const offset = hc_list_row(sweep->walls, i);
  const int32_t count = hc_list_count(sweep->walls, i);
  bool any = false;
  for (int32_t k = 0; k < count && !any; k++)
    any = wanted[(int)sweep->boundary->motion[offset[k] / sizeof(hc_record)].scalar];
  return any;
}

void hc_wall_force_each(const hc_sweep *sweep, const hc_frame *frame, double dt, const bool *wanted,
                        hc_wall_push_taker take, void *context) {
  const double back = dt - hc_wall_force_later(sweep, dt);
  size_t next_hold = 0, next_touch = 0, room = 0;
  pair *pairs = NULL;
  for (int32_t i = 0; i < sweep->fluid->own; i++) {
    if (!any_wanted(sweep, i, wanted)) continue;
    pusher p = {.sweep = sweep,
                .i = i,
                .count = hc_list_count(sweep->walls, i),
                .contact = contact_of(sweep, i, &next_hold),
                .touch = touch_of(sweep, i, &next_touch)};
    hc_reserve((void **)&pairs, &room, (size_t)p.count, 0, sizeof *pairs);
    p.pairs = pairs;
    for (int32_t k = 0; k < p.count; k++) pairs[k] = make_pair(sweep, i, hc_list_row(sweep->walls, i)[k]);
    const hc_dragger drag = hc_wall_drag_by(sweep, i, dt);
    if (look_at_pairs(&p, dt) || drag.factor != 0.0) share_out(&p, &drag, frame, back, dt, take, context);
  }
  hc_free(pairs);
}
