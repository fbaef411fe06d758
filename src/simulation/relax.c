#include "relax.h"

#include "base/memory.h"
#include "particles/ids.h"

#include <math.h>
#include <string.h>

/* Farther than this no particle moves in a step, half spacings: half a radius (not in the paper). */
static const double FARTHEST = 0.5;

typedef struct relax {
  const hc_resting *resting;
  const hc_relaxing *how;
  int64_t *before; /* positions, three a particle */
  size_t room;
  double half; /* m: half a spacing */
} relax;

static bool is_held(const hc_particles *fluid, int32_t k) {
  return hc_id_kind_of(fluid->id[k]) == HC_ID_HELD;
}

/* The mean and the largest of the speeds that the step found, in half spacings a step. */
static void note_speeds(const relax *r, hc_relaxed *result) {
  const hc_particles *const fluid = r->resting->world->fluid;
  hc_sum sum;
  memset(&sum, 0, sizeof sum);
  int64_t moving = 0;
  double most = 0.0;
  for (int32_t k = 0; k < fluid->own; k++) {
    if (is_held(fluid, k)) continue;
    const double *const v = &fluid->velocity[3 * (size_t)k],
                        speed = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) * r->how->dt / r->half;
    hc_sum_add(&sum, speed);
    most = fmax(most, speed);
    moving++;
  }
  hc_tally tally = {.count = 0};
  hc_tally_sum_exact(&tally, &sum, 1);
  hc_tally_sum_i64(&tally, &moving, 1);
  hc_tally_max_f64(&tally, &most, 1);
  hc_tally_reduce(r->resting->world->comm, &tally);
  result->speed_max = most;
  result->speed_avg = moving > 0 ? hc_sum_value(&sum) / (double)moving : 0.0;
}

/* Moves what is not held anew, from where it was. */
static void move_damped(const relax *r, double damping) {
  const hc_frame *const frame = &r->resting->world->frame;
  hc_particles *const fluid = r->resting->world->fluid;
  for (int32_t k = 0; k < fluid->own; k++) {
    double *const v = &fluid->velocity[3 * (size_t)k];
    const double speed = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) * r->how->dt / r->half;
    const double keeps =
        is_held(fluid, k) ? 0.0 : (1.0 - damping) * (speed > FARTHEST ? FARTHEST / speed : 1.0);
    for (int axis = 0; axis < 3; axis++) {
      v[axis] *= keeps;
      const size_t at = 3 * (size_t)k + (size_t)axis;
      fluid->position[at] =
          hc_frame_wrap(frame, axis, r->before[at] + llrint(v[axis] * r->how->dt / frame->unit[axis]));
    }
  }
}

static hc_status step(relax *r, double dt_before, hc_error *error) {
  const hc_resting *const resting = r->resting;
  hc_world *const world = resting->world;
  hc_domain_forget_partners(&world->domain);
  hc_world_place(world);
  hc_bodies_touch(resting->bodies, world);
  hc_world_list(world, NULL);
  const size_t coordinates = 3 * (size_t)world->fluid->own;
  hc_reserve((void **)&r->before, &r->room, coordinates + 1, 0, sizeof *r->before);
  memcpy(r->before, world->fluid->position, coordinates * sizeof *r->before);
  if (resting->solver->evaluate) resting->solver->evaluate(world, resting->settings, resting->report);
  return resting->solver->step(world, NULL, resting->settings, r->how->dt, dt_before, resting->report, error);
}

/* What is otherwise in damped steps: when the solver's iterations end; and what is at rest has no friction.
 */
typedef struct usual {
  double error_avg;
  int most;
  hc_viscous_force viscosity;
  const hc_wall_friction *friction;
} usual;

static usual change_settings(const hc_resting *resting, const hc_relaxing *how) {
  usual before = {.viscosity = resting->settings->viscosity, .friction = resting->world->sweep.friction};
  resting->settings->viscosity = HC_VISCOUS_NONE;
  resting->world->sweep.friction = NULL;
  if (!resting->solver->effort) return before;
  const hc_solver_effort effort = resting->solver->effort(resting->settings);
  before.error_avg = *effort.error_avg;
  before.most = *effort.most;
  if (how->density_error_avg > 0.0) *effort.error_avg = how->density_error_avg;
  if (how->iterations > 0) *effort.most = how->iterations;
  return before;
}

static void restore_settings(const hc_resting *resting, const usual *before) {
  resting->settings->viscosity = before->viscosity;
  resting->world->sweep.friction = before->friction;
  if (!resting->solver->effort) return;
  const hc_solver_effort effort = resting->solver->effort(resting->settings);
  *effort.error_avg = before->error_avg;
  *effort.most = before->most;
}

hc_status hc_relax(const hc_resting *resting, const hc_relaxing *how, hc_relaxed *result, hc_error *error) {
  hc_world *const world = resting->world;
  hc_particles *const fluid = world->fluid;
  relax r = {.resting = resting, .how = how, .half = 0.5 * resting->spacing};
  const usual before = change_settings(resting, how);
  double factor = how->steps > 1 ? pow(how->damping_end / how->damping_start, 1.0 / (how->steps - 1)) : 1.0;
  hc_comm_broadcast(world->comm, &factor, sizeof factor, 0); /* machines may differ in the last bit */
  double damping = how->damping_start;
  memset(fluid->velocity, 0, 3 * (size_t)fluid->own * sizeof *fluid->velocity);
  memset(result, 0, sizeof *result);
  world->holding = true;
  for (int k = 0; k < how->steps && !result->at_rest; k++, damping *= factor) {
    if (step(&r, k > 0 ? how->dt : 0.0, error) != HC_OK) break;
    note_speeds(&r, result);
    result->steps++;
    result->at_rest = result->speed_max <= how->speed_max && result->speed_avg <= how->speed_avg;
    move_damped(&r, damping);
  }
  world->holding = false;
  restore_settings(resting, &before);
  memset(fluid->velocity, 0, 3 * (size_t)fluid->own * sizeof *fluid->velocity);
  hc_free(r.before);
  hc_domain_forget_partners(&world->domain);
  if (error->status == HC_OK) return HC_OK;
  const hc_error found = *error;
  return hc_error_set(error, HC_FAILED, "the fluid diverged while it came to rest, damped step %d: %.4000s",
                      result->steps + 1, found.text);
}
