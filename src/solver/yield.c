#include "yield.h"

#include "base/memory.h"
#include "geometry/vector.h"
#include "wall_force.h"
#include "wall_weight.h"

#include <math.h>
#include <string.h>

static bool is_none(const hc_bodies *bodies) {
  return !bodies || bodies->count == 0;
}

/* ---- impulses ---- */

static const double FINEST = 0x1p-40; /* of a body's momentum at a support radius a step */
static const double MOST = 0x1p48;    /* units: a single impulse beyond is none that a run could go on from */

static void start_impulses(hc_impulses *impulses, const hc_world *world, const hc_bodies *bodies, double dt) {
  if (!impulses->sum) impulses->sum = hc_alloc((size_t)(6 * bodies->count), sizeof *impulses->sum);
  memset(impulses->sum, 0, (size_t)(6 * bodies->count) * sizeof *impulses->sum);
  impulses->bodies = bodies->count;
  impulses->broken = 0;
  impulses->speed = FINEST * world->frame.support_radius / dt;
}

void hc_impulses_free(hc_impulses *impulses) {
  hc_free(impulses->sum);
  memset(impulses, 0, sizeof *impulses);
}

static void add_impulse(hc_impulses *impulses, const hc_body *body, int number, const double linear[3],
                        const double angular[3]) {
  const double unit = body->mass * impulses->speed, moment = unit * body->reach;
  for (int axis = 0; axis < 3; axis++) {
    const double parts[2] = {linear[axis] / unit, angular[axis] / moment};
    for (int part = 0; part < 2; part++) {
      if (fabs(parts[part]) < MOST)
        impulses->sum[6 * number + 3 * part + axis] += llrint(parts[part]);
      else
        impulses->broken = 1;
    }
  }
}

static void note_impulses(hc_impulses *impulses, hc_tally *tally) {
  hc_tally_sum_i64(tally, impulses->sum, 6 * impulses->bodies);
  hc_tally_max_i64(tally, &impulses->broken, 1);
}

static hc_twist impulse_on(const hc_impulses *impulses, const hc_body *body, int number) {
  const double unit = body->mass * impulses->speed, moment = unit * body->reach;
  hc_twist impulse;
  for (int axis = 0; axis < 3; axis++) {
    impulse.linear[axis] = unit * (double)impulses->sum[6 * number + axis];
    impulse.angular[axis] = moment * (double)impulses->sum[6 * number + 3 + axis];
  }
  return impulse;
}

/* ---- who is next to what ---- */

/* The pair of a particle and a body: one of the particle's, which begin at `first`, or a new one. */
static hc_yield_pair *pair_of(hc_yield *yield, size_t first, int32_t particle, int32_t body) {
  for (size_t k = first; k < yield->count; k++)
    if (yield->pairs[k].body == body) return &yield->pairs[k];
  hc_reserve((void **)&yield->pairs, &yield->room, 2 * yield->count + 64, yield->count, sizeof *yield->pairs);
  yield->pairs[yield->count] = (hc_yield_pair){.particle = particle, .body = body};
  return &yield->pairs[yield->count++];
}

static void find_pairs_of(hc_yield *yield, int32_t i) {
  const hc_sweep *const sweep = &yield->world->sweep;
  const uint32_t *const row = hc_list_row(sweep->walls, i);
  const size_t first = yield->count;
  double normal[3];
  bool looked = false;
  for (int32_t k = 0; k < hc_list_count(sweep->walls, i); k++) {
    const int32_t b = (int32_t)(row[k] / sizeof(hc_record));
    const hc_body *const body = hc_bodies_of(yield->bodies, (int)sweep->boundary->motion[b].scalar);
    if (!body) continue;
    if (!looked) hc_wall_weight_normal(sweep, i, normal);
    looked = true;
    double d[3], arm[3];
    hc_sweep_from_wall(sweep, i, b, d);
    const double q = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    if (!(q < 1.0)) continue;
    const double factor = hc_wall_weight(sweep, b, normal) * (double)sweep->boundary->place[b].scalar *
                          (double)sweep->gradient * hc_kernel_slope_over_q(q);
    hc_yield_pair *const pair = pair_of(yield, first, i, (int32_t)(body - yield->bodies->body));
    hc_body_arm(yield->bodies, body, &sweep->fluid->position[3 * (size_t)i], arm);
    double gradient[3], moment[3];
    for (int axis = 0; axis < 3; axis++) {
      gradient[axis] = factor * d[axis];
      arm[axis] -= d[axis] * (double)sweep->support;
    }
    hc_vector_cross(arm, gradient, moment);
    for (int axis = 0; axis < 3; axis++) {
      pair->linear[axis] += gradient[axis];
      pair->angular[axis] += moment[axis];
    }
  }
}

void hc_yield_begin(hc_yield *yield, hc_world *world, hc_bodies *bodies, double dt) {
  *yield = (hc_yield){.world = world, .bodies = bodies, .dt = dt};
  if (is_none(bodies)) return;
  start_impulses(&yield->impulses, world, bodies, dt);
  for (int k = 0; k < bodies->count; k++) memset(&bodies->body[k].pushed, 0, sizeof bodies->body[k].pushed);
  bodies->reckons = true;
  for (int32_t i = 0; i < world->fluid->own; i++)
    if (hc_list_count(&world->walls, i) > 0) find_pairs_of(yield, i);
}

void hc_yield_end(hc_yield *yield) {
  hc_impulses_free(&yield->impulses);
  hc_free(yield->pairs);
  hc_free(yield->softness);
  hc_free(yield->base);
}

/* m (G.G/M + T.C T): what a pair adds to the diagonal of the pressure's matrix by its body alone. */
static double softness_of(const hc_yield *yield, const hc_yield_pair *pair) {
  const hc_body *const body = &yield->bodies->body[pair->body];
  double sum = 0.0;
  for (int axis = 0; axis < 3; axis++) {
    if (!(body->locked >> axis & 1)) sum += pair->linear[axis] * pair->linear[axis] / body->mass;
    sum += pair->angular[axis] * hc_vector_dot(body->compliance[axis], pair->angular);
  }
  return yield->world->mass * sum;
}

void hc_yield_measure(hc_yield *yield) {
  static const double SHARE = 0.5; /* of the trace: of six ways to yield none is all of it */
  const hc_bodies *const bodies = yield->bodies;
  if (is_none(bodies)) return;
  hc_sum *const sums = hc_alloc_zero((size_t)bodies->count, sizeof *sums);
  for (size_t k = 0; k < yield->count; k++)
    hc_sum_add(&sums[yield->pairs[k].body], softness_of(yield, &yield->pairs[k]));
  hc_tally tally = {.count = 0};
  hc_tally_sum_exact(&tally, sums, bodies->count);
  hc_tally_reduce(yield->world->comm, &tally);
  yield->softness = hc_alloc((size_t)bodies->count, sizeof *yield->softness);
  for (int k = 0; k < bodies->count; k++) yield->softness[k] = SHARE * hc_sum_value(&sums[k]);
  hc_free(sums);
}

void hc_yield_soften(hc_yield *yield) {
  if (is_none(yield->bodies)) return;
  for (size_t k = 0; k < yield->count; k++) {
    float *const alpha = &yield->world->fluid->alpha[yield->pairs[k].particle];
    *alpha = (float)((double)*alpha / (1.0 + (double)*alpha * yield->softness[yield->pairs[k].body]));
  }
}

/* ---- within a solver ---- */

static void push(hc_body *body, const hc_twist *impulse) {
  hc_body_push_shown(body, impulse);
  for (int axis = 0; axis < 3; axis++) {
    body->pushed.linear[axis] += impulse->linear[axis];
    body->pushed.angular[axis] += impulse->angular[axis];
  }
}

/* Wall rates of particles next to a body follow its velocity; `before`: of each body. */
static void follow(hc_yield *yield, const hc_twist *before) {
  float *const rate = yield->world->fluid->wall_rate;
  for (size_t k = 0; k < yield->count; k++) {
    const hc_yield_pair *const pair = &yield->pairs[k];
    const hc_twist *const now = &yield->bodies->body[pair->body].shown, *const then = &before[pair->body];
    double change = 0.0;
    for (int axis = 0; axis < 3; axis++)
      change += (now->linear[axis] - then->linear[axis]) * pair->linear[axis] +
                (now->angular[axis] - then->angular[axis]) * pair->angular[axis];
    rate[pair->particle] += (float)change;
  }
}

static hc_twist *shown_of(const hc_bodies *bodies) {
  hc_twist *const shown = hc_alloc((size_t)bodies->count, sizeof *shown);
  for (int k = 0; k < bodies->count; k++) shown[k] = bodies->body[k].shown;
  return shown;
}

void hc_yield_accelerate(hc_yield *yield) {
  hc_bodies *const bodies = yield->bodies;
  if (is_none(bodies)) return;
  hc_twist *const before = shown_of(bodies);
  for (int k = 0; k < bodies->count; k++) {
    hc_body *const body = &bodies->body[k];
    hc_twist impulse = hc_body_pull(bodies, body);
    for (int axis = 0; axis < 3; axis++) {
      impulse.linear[axis] = yield->dt * (impulse.linear[axis] + body->held[axis]);
      impulse.angular[axis] = yield->dt * (impulse.angular[axis] + body->held[3 + axis]);
    }
    push(body, &impulse);
  }
  follow(yield, before);
  hc_free(before);
}

void hc_yield_note(hc_yield *yield, double weight, hc_tally *tally) {
  const hc_bodies *const bodies = yield->bodies;
  if (is_none(bodies)) return;
  const hc_particles *const fluid = yield->world->fluid;
  start_impulses(&yield->impulses, yield->world, bodies, yield->dt);
  for (size_t k = 0; k < yield->count; k++) {
    const hc_yield_pair *const pair = &yield->pairs[k];
    const double factor = yield->world->mass * weight * (double)fluid->place[pair->particle].scalar;
    if (factor == 0.0) continue;
    double linear[3], angular[3];
    for (int axis = 0; axis < 3; axis++) {
      linear[axis] = factor * pair->linear[axis];
      angular[axis] = factor * pair->angular[axis];
    }
    add_impulse(&yield->impulses, &bodies->body[pair->body], pair->body, linear, angular);
  }
  note_impulses(&yield->impulses, tally);
}

void hc_yield_act(hc_yield *yield) {
  hc_bodies *const bodies = yield->bodies;
  if (is_none(bodies)) return;
  hc_twist *const before = shown_of(bodies);
  for (int k = 0; k < bodies->count; k++) {
    const hc_twist impulse = impulse_on(&yield->impulses, &bodies->body[k], k);
    push(&bodies->body[k], &impulse);
  }
  follow(yield, before);
  hc_free(before);
}

void hc_yield_retry(hc_yield *yield, double diagonal) {
  hc_bodies *const bodies = yield->bodies;
  if (is_none(bodies)) return;
  if (!yield->base) {
    yield->base = hc_alloc((size_t)bodies->count, sizeof *yield->base);
    for (int k = 0; k < bodies->count; k++)
      yield->base[k] = (hc_yield_base){bodies->body[k].shown, bodies->body[k].pushed};
  }
  for (int k = 0; k < bodies->count; k++) {
    hc_body *const body = &bodies->body[k];
    const hc_twist impulse = impulse_on(&yield->impulses, body, k), before = body->shown;
    const double share = 1.0 / (1.0 + yield->softness[k] / diagonal);
    body->shown = yield->base[k].shown;
    body->pushed = yield->base[k].pushed;
    push(body, &impulse);
    for (int axis = 0; axis < 3; axis++) {
      double *const now[2] = {&body->shown.linear[axis], &body->shown.angular[axis]};
      const double then[2] = {before.linear[axis], before.angular[axis]};
      for (int part = 0; part < 2; part++) *now[part] = then[part] + share * (*now[part] - then[part]);
    }
  }
}

void hc_yield_show(hc_yield *yield) {
  if (is_none(yield->bodies)) return;
  hc_store *const moving = &yield->world->stores[HC_STORE_MOVING];
  hc_bodies_drive(yield->bodies, &moving->particles);
  hc_halo_refresh(&moving->halo, HC_WHOLE(motion));
  moving->moved = true;
}

/* ---- behind a step ---- */

/* What one particle pushes one body with: force, and moment about the particle. */
typedef struct taking {
  hc_impulses *loads;
  const hc_bodies *bodies;
  const hc_body *body; /* null: nothing yet */
  int32_t particle;
  double dt, by[3]; /* by: its place, m */
  hc_twist force;
} taking;

/* Enters what the particle has pushed the body with. */
static void finish_taking(taking *t) {
  if (!t->body) return;
  double linear[3], arm[3], angular[3];
  for (int axis = 0; axis < 3; axis++) {
    const hc_frame *const frame = t->bodies->frame;
    const double period = (double)frame->period[axis] * frame->unit[axis];
    linear[axis] = t->dt * t->force.linear[axis];
    arm[axis] = t->by[axis] - hc_frame_to_metres(frame, axis, t->body->position[axis]);
    if (period > 0.0) arm[axis] -= period * rint(arm[axis] / period);
  }
  hc_vector_cross(arm, linear, angular);
  for (int axis = 0; axis < 3; axis++) angular[axis] += t->dt * t->force.angular[axis];
  add_impulse(t->loads, t->body, (int)(t->body - t->bodies->body), linear, angular);
}

static void take_push(void *context, const hc_wall_push *push) {
  taking *const t = context;
  const int number = push->wall - t->bodies->first;
  if (number < 0) return;
  const hc_body *const body = &t->bodies->body[number];
  if (body != t->body || push->particle != t->particle) {
    finish_taking(t);
    t->body = body;
    t->particle = push->particle;
    t->force = (hc_twist){{0.0}, {0.0}};
    memcpy(t->by, push->by, sizeof t->by);
  }
  for (int axis = 0; axis < 3; axis++) {
    t->force.linear[axis] += push->force[axis];
    t->force.angular[axis] += push->moment[axis];
  }
}

void hc_yield_note_loads(hc_impulses *loads, const hc_world *world, hc_bodies *bodies, double dt,
                         hc_tally *tally) {
  if (is_none(bodies)) return;
  start_impulses(loads, world, bodies, dt);
  bool *const wanted = hc_alloc_zero((size_t)(bodies->first + bodies->count), sizeof *wanted);
  for (int k = 0; k < bodies->count; k++) wanted[bodies->first + k] = true;
  taking taking = {.loads = loads, .bodies = bodies, .dt = dt};
  hc_wall_force_each(&world->sweep, &world->frame, dt, wanted, true, take_push, &taking);
  finish_taking(&taking);
  hc_free(wanted);
  note_impulses(loads, tally);
  hc_tally_max_i64(tally, &bodies->touching.any, 1);
}

hc_status hc_yield_take_loads(hc_impulses *loads, hc_bodies *bodies, double dt, hc_error *error) {
  if (is_none(bodies)) return HC_OK;
  if (loads->broken)
    return hc_error_set(error, HC_FAILED, "the fluid pushes a body with a force beyond all measure");
  for (int k = 0; k < bodies->count; k++) {
    hc_body *const body = &bodies->body[k];
    const hc_twist pull = hc_body_pull(bodies, body);
    hc_twist impulse = impulse_on(loads, body, k);
    for (int axis = 0; axis < 3; axis++) {
      body->load[axis] = impulse.linear[axis] / dt;
      body->load[3 + axis] = impulse.angular[axis] / dt;
      impulse.linear[axis] += dt * pull.linear[axis];
      impulse.angular[axis] += dt * pull.angular[axis];
    }
    hc_body_push(body, &impulse);
  }
  return HC_OK;
}
