#include "bodies.h"

#include "base/memory.h"
#include "geometry/vector.h"
#include "particles/ids.h"

#include <math.h>
#include <string.h>

static void times(const double m[3][3], const double v[3], double product[3]) {
  for (int axis = 0; axis < 3; axis++) product[axis] = hc_vector_dot(m[axis], v);
}

/* ---- all bodies ---- */

void hc_bodies_init(hc_bodies *bodies, int count, const hc_frame *frame) {
  *bodies =
      (hc_bodies){.body = hc_alloc_zero((size_t)count, sizeof *bodies->body), .count = count, .frame = frame};
  hc_touching_init(&bodies->touching);
}

void hc_bodies_touch(hc_bodies *bodies, hc_world *world) {
  if (bodies->count > 0) hc_touching_refresh(&bodies->touching, world, bodies->first);
}

void hc_bodies_free(hc_bodies *bodies) {
  hc_touching_free(&bodies->touching);
  for (int k = 0; k < bodies->count; k++) {
    hc_free(bodies->body[k].pulls);
    hc_free(bodies->body[k].moorings);
  }
  hc_free(bodies->body);
  memset(bodies, 0, sizeof *bodies);
}

void hc_bodies_register(hc_bodies *bodies, hc_state *state) {
  for (int k = 0; k < bodies->count; k++) {
    hc_body *const body = &bodies->body[k];
    hc_state_add(state, HC_TYPE_i64, 3, body->position, "bodies.%d.position", k);
    hc_state_add(state, HC_TYPE_f64, 4, body->turn, "bodies.%d.turn", k);
    hc_state_add(state, HC_TYPE_f64, 3, body->velocity, "bodies.%d.velocity", k);
    hc_state_add(state, HC_TYPE_f64, 3, body->momentum, "bodies.%d.momentum", k);
    hc_state_add(state, HC_TYPE_f64, 6, body->held, "bodies.%d.held", k);
    hc_state_add(state, HC_TYPE_f64, 6, body->load, "bodies.%d.load", k);
  }
}

hc_body *hc_bodies_of(const hc_bodies *bodies, int wall) {
  const int k = wall - bodies->first;
  return bodies->count > 0 && k >= 0 && k < bodies->count ? &bodies->body[k] : NULL;
}

/* ---- how a body stands ---- */

/* The rotation of a quaternion less the identity: exactly 0 without a turn. */
static void turn_of(const double q[4], double turn[3][3]) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  const double rows[3][3] = {{-2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                             {2 * (x * y + w * z), -2 * (x * x + z * z), 2 * (y * z - w * x)},
                             {2 * (x * z - w * y), 2 * (y * z + w * x), -2 * (x * x + y * y)}};
  memcpy(turn, rows, sizeof rows);
}

static void apply_turn(const double q[4], const double v[3], double turned[3]) {
  double turn[3][3];
  turn_of(q, turn);
  times(turn, v, turned);
  for (int axis = 0; axis < 3; axis++) turned[axis] += v[axis];
}

void hc_body_turned(const hc_body *body, const double arm[3], double turned[3]) {
  apply_turn(body->turn, arm, turned);
}

/* R I R^T */
static void inertia_at(const hc_body *body, const double q[4], double inertia[3][3]) {
  double column[3][3], half[3][3]; /* half[b]: row b of R I, as columns of I R^T */
  for (int b = 0; b < 3; b++) {
    const double row[3] = {body->inertia[0][b], body->inertia[1][b], body->inertia[2][b]};
    apply_turn(q, row, column[b]); /* R I e_b */
  }
  for (int a = 0; a < 3; a++) {
    const double row[3] = {column[0][a], column[1][a], column[2][a]};
    apply_turn(q, row, half[a]);
  }
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) inertia[a][b] = 0.5 * (half[a][b] + half[b][a]);
}

/* The inverse, where turns that are locked have an infinite inertia: 0 there. */
static void invert(double m[3][3], unsigned locked_turns, double inverse[3][3]) {
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      if (locked_turns >> a & 1 || locked_turns >> b & 1) m[a][b] = a == b ? 1.0 : 0.0;
  double adjoint[3][3];
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) {
      const int c = (a + 1) % 3, d = (a + 2) % 3, e = (b + 1) % 3, f = (b + 2) % 3;
      adjoint[b][a] = m[c][e] * m[d][f] - m[c][f] * m[d][e];
    }
  const double whole = m[0][0] * adjoint[0][0] + m[0][1] * adjoint[1][0] + m[0][2] * adjoint[2][0];
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) {
      const bool locked = locked_turns >> a & 1 || locked_turns >> b & 1;
      inverse[a][b] = locked ? 0.0 : adjoint[a][b] / whole;
    }
}

static void compliance_at(const hc_body *body, const double q[4], double compliance[3][3]) {
  double inertia[3][3];
  inertia_at(body, q, inertia);
  invert(inertia, body->locked >> 3, compliance);
}

void hc_body_spin(const hc_body *body, double spin[3]) {
  times(body->compliance, body->momentum, spin);
}

static void show(hc_body *body) {
  memcpy(body->shown.linear, body->velocity, sizeof body->shown.linear);
  hc_body_spin(body, body->shown.angular);
}

static void pose(const hc_bodies *bodies, hc_body *body, hc_pose *pose) {
  memset(pose, 0, sizeof *pose);
  compliance_at(body, body->turn, body->compliance);
  show(body);
  for (int axis = 0; axis < 3; axis++)
    pose->units[axis] = body->position[axis] - hc_frame_to_units(bodies->frame, axis, body->centre[axis]);
  turn_of(body->turn, pose->turn);
  memcpy(pose->velocity, body->shown.linear, sizeof pose->velocity);
  memcpy(pose->spin, body->shown.angular, sizeof pose->spin);
}

void hc_bodies_pose(hc_bodies *bodies, double time, hc_movers *movers) {
  bodies->time = time;
  for (int k = 0; k < movers->count; k++) {
    hc_body *const body = hc_bodies_of(bodies, movers->walls[k].wall);
    if (body) pose(bodies, body, &movers->walls[k].given);
  }
}

void hc_body_arm(const hc_bodies *bodies, const hc_body *body, const int64_t position[3], double arm[3]) {
  for (int axis = 0; axis < 3; axis++) {
    const int64_t period = bodies->frame->period[axis];
    int64_t units = position[axis] - body->position[axis];
    if (period > 0) {
      units %= period;
      if (units >= period - period / 2) units -= period;
      if (units < -(period / 2)) units += period;
    }
    arm[axis] = (double)units * bodies->frame->unit[axis];
  }
}

/* ---- what pushes it ---- */

void hc_twist_at(const hc_twist *twist, const double arm[3], double velocity[3]) {
  hc_vector_cross(twist->angular, arm, velocity);
  for (int axis = 0; axis < 3; axis++) velocity[axis] += twist->linear[axis];
}

void hc_twist_add_at(hc_twist *twist, const double arm[3], const double impulse[3]) {
  double moment[3];
  hc_vector_cross(arm, impulse, moment);
  for (int axis = 0; axis < 3; axis++) {
    twist->linear[axis] += impulse[axis];
    twist->angular[axis] += moment[axis];
  }
}

static void add_pull(const hc_body *body, const hc_pull *pull, double time, hc_twist *sum) {
  if (time < pull->start || time >= pull->stop) return;
  double arm[3], force[3];
  hc_body_turned(body, pull->arm, arm);
  if (pull->turns)
    hc_body_turned(body, pull->force, force);
  else
    memcpy(force, pull->force, sizeof force);
  hc_twist_add_at(sum, arm, force);
}

/* How hard a mooring pulls, N, and where it holds the body: the arm, and from there to its other end, of unit
 * length. */
static double tension_of(const hc_bodies *bodies, const hc_body *body, const hc_mooring *mooring,
                         double arm[3], double along[3]) {
  hc_twist moves;
  memcpy(moves.linear, body->velocity, sizeof moves.linear);
  hc_body_spin(body, moves.angular);
  double at[3];
  hc_body_turned(body, mooring->arm, arm);
  hc_twist_at(&moves, arm, at);
  for (int axis = 0; axis < 3; axis++)
    along[axis] =
        mooring->anchor[axis] - arm[axis] - hc_frame_to_metres(bodies->frame, axis, body->position[axis]);
  const double length = hc_vector_length(along);
  hc_vector_normalize(along);
  const double tension =
      mooring->stiffness * (length - mooring->length) - mooring->damping * hc_vector_dot(along, at);
  if (length == 0.0) return 0.0;
  return mooring->pushes || (length > mooring->length && tension > 0.0) ? tension : 0.0;
}

double hc_body_tension(const hc_bodies *bodies, const hc_body *body, int mooring) {
  double arm[3], along[3];
  return tension_of(bodies, body, &body->moorings[mooring], arm, along);
}

static void add_mooring(const hc_bodies *bodies, const hc_body *body, const hc_mooring *mooring,
                        hc_twist *sum) {
  double arm[3], along[3];
  const double tension = tension_of(bodies, body, mooring, arm, along);
  for (int axis = 0; axis < 3; axis++) along[axis] *= tension;
  hc_twist_add_at(sum, arm, along);
}

hc_twist hc_body_pull(const hc_bodies *bodies, const hc_body *body) {
  hc_twist sum = {.linear = {0.0, 0.0, 0.0}};
  const double square = bodies->central_rate * bodies->central_rate;
  for (int axis = 0; axis < 3; axis++) {
    const double off =
        bodies->frame->period[axis] > 0
            ? 0.0
            : hc_frame_to_metres(bodies->frame, axis, body->position[axis]) - bodies->pole[axis];
    sum.linear[axis] = body->mass * (bodies->gravity[axis] - square * off);
  }
  for (int k = 0; k < body->pull_count; k++) add_pull(body, &body->pulls[k], bodies->time, &sum);
  for (int k = 0; k < body->mooring_count; k++) add_mooring(bodies, body, &body->moorings[k], &sum);
  return sum;
}

/* The change of velocity that an impulse makes. */
static hc_twist change_by(const hc_body *body, const hc_twist *impulse) {
  hc_twist change;
  for (int axis = 0; axis < 3; axis++)
    change.linear[axis] = body->locked >> axis & 1 ? 0.0 : impulse->linear[axis] / body->mass;
  times(body->compliance, impulse->angular, change.angular);
  return change;
}

void hc_body_push_shown(hc_body *body, const hc_twist *impulse) {
  const hc_twist change = change_by(body, impulse);
  for (int axis = 0; axis < 3; axis++) {
    body->shown.linear[axis] += change.linear[axis];
    body->shown.angular[axis] += change.angular[axis];
  }
}

void hc_body_push(hc_body *body, const hc_twist *impulse) {
  const hc_twist change = change_by(body, impulse);
  for (int axis = 0; axis < 3; axis++) {
    body->velocity[axis] += change.linear[axis];
    if (!(body->locked >> (3 + axis) & 1)) body->momentum[axis] += impulse->angular[axis];
  }
}

hc_twist hc_body_momentum(const hc_body *body) {
  hc_twist momentum;
  for (int axis = 0; axis < 3; axis++) momentum.linear[axis] = body->mass * body->velocity[axis];
  memcpy(momentum.angular, body->momentum, sizeof momentum.angular);
  return momentum;
}

/* What of the impulse of contacts bears and will again: all but what has changed the momentum its way. */
static double bearing_share(const double now[3], const double before[3], const double pushed[3]) {
  double change[3], contact[3];
  hc_vector_minus(now, before, change);
  hc_vector_minus(now, pushed, contact);
  const double square = hc_vector_dot(contact, contact);
  if (square == 0.0) return 0.0;
  return 1.0 - fmax(0.0, fmin(1.0, hc_vector_dot(change, contact) / square));
}

void hc_body_expect(const hc_bodies *bodies, hc_body *body, const hc_twist *before, const hc_twist *pushed,
                    double dt) {
  if (!bodies->reckons) return;
  const hc_twist now = hc_body_momentum(body);
  const double linear = bearing_share(now.linear, before->linear, pushed->linear),
               angular = bearing_share(now.angular, before->angular, pushed->angular);
  for (int axis = 0; axis < 3; axis++) {
    const double beyond = pushed->linear[axis] - before->linear[axis] - body->pushed.linear[axis] +
                          linear * (now.linear[axis] - pushed->linear[axis]),
                 about = pushed->angular[axis] - before->angular[axis] - body->pushed.angular[axis] +
                         angular * (now.angular[axis] - pushed->angular[axis]);
    body->held[axis] = body->locked >> axis & 1 ? 0.0 : body->held[axis] + beyond / dt;
    body->held[3 + axis] = body->locked >> (3 + axis) & 1 ? 0.0 : body->held[3 + axis] + about / dt;
  }
}

/* ---- how it moves ---- */

/* The quaternion behind a turn of `spin` over dt: (1 + dt/2 spin) q, of unit length, Cayley's map, without
 * sines. */
static void turn_on(const double q[4], const double spin[3], double dt, double turned[4]) {
  const double x = 0.5 * dt * spin[0], y = 0.5 * dt * spin[1], z = 0.5 * dt * spin[2];
  const double w = q[0], a = q[1], b = q[2], c = q[3];
  turned[0] = w - x * a - y * b - z * c;
  turned[1] = a + x * w + y * c - z * b;
  turned[2] = b + y * w + z * a - x * c;
  turned[3] = c + z * w + x * b - y * a;
  const double length =
      sqrt(turned[0] * turned[0] + turned[1] * turned[1] + turned[2] * turned[2] + turned[3] * turned[3]);
  for (int k = 0; k < 4; k++) turned[k] /= length;
}

/* From the turn before to that behind dt, with the spin of the middle between the two. */
static void turn_body(hc_body *body, double dt) {
  enum { PASSES = 8 };
  double next[4];
  memcpy(next, body->turn, sizeof next);
  for (int pass = 0; pass < PASSES; pass++) {
    double middle[4], square = 0.0, compliance[3][3], spin[3];
    for (int k = 0; k < 4; k++) {
      middle[k] = body->turn[k] + next[k];
      square += middle[k] * middle[k];
    }
    for (int k = 0; k < 4; k++) middle[k] /= sqrt(square);
    compliance_at(body, middle, compliance);
    times(compliance, body->momentum, spin);
    turn_on(body->turn, spin, dt, next);
  }
  memcpy(body->turn, next, sizeof next);
}

bool hc_body_drift(const hc_bodies *bodies, hc_body *body, double dt) {
  static const double FARTHEST = 0x1p50; /* units */
  for (int axis = 0; axis < 3; axis++) {
    const double units = body->velocity[axis] * dt / bodies->frame->unit[axis];
    if (!(fabs(units) < FARTHEST)) return false;
    body->position[axis] += llrint(units);
  }
  if (hc_vector_dot(body->momentum, body->momentum) > 0.0) turn_body(body, dt);
  compliance_at(body, body->turn, body->compliance);
  return true;
}

void hc_body_angles(const hc_body *body, double angles[3]) {
  const double degrees = 180 / 3.14159265358979323846;
  double turn[3][3];
  turn_of(body->turn, turn);
  for (int axis = 0; axis < 3; axis++) turn[axis][axis] += 1.0;
  angles[0] = degrees * atan2(turn[2][1], turn[2][2]);
  angles[1] = degrees * asin(fmax(-1.0, fmin(1.0, -turn[2][0])));
  angles[2] = degrees * atan2(turn[1][0], turn[0][0]);
}

void hc_bodies_drive(const hc_bodies *bodies, hc_particles *moving) {
  for (int32_t k = 0; k < moving->own; k++) {
    const hc_body *const body = hc_bodies_of(bodies, (int)hc_id_source_of(moving->id[k]));
    if (!body) continue;
    double arm[3], velocity[3];
    hc_body_arm(bodies, body, &moving->position[3 * (size_t)k], arm);
    hc_twist_at(&body->shown, arm, velocity);
    for (int axis = 0; axis < 3; axis++) moving->motion[k].v[axis] = (float)velocity[axis];
  }
}
