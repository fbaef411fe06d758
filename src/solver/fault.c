#include "fault.h"

#include <math.h>

/* A position beyond this is none: another step could overflow it. Units. */
static const int64_t WORLD_END = (int64_t)1 << 60;

void hc_fault_note(hc_fault *fault, hc_fault_kind kind, double value, uint64_t id) {
  if (fault->kind != HC_FAULT_NONE) {
    if (kind > fault->kind) return;
    if (kind == fault->kind && (value < fault->value || (value == fault->value && id >= fault->id))) return;
  }
  *fault = (hc_fault){kind, value, id};
}

/* Velocities that are no number, or carry their particle farther than its neighbours were looked for. */
static void watch_velocities(const hc_world *world, double dt, hc_fault_kind no_number, hc_fault_kind fast,
                             hc_fault *fault) {
  const hc_particles *fluid = world->fluid;
  static const double DAMPED = 1000.0; /* damped steps are cut to what is safe (simulation/relax.h) */
  const double limit = (world->holding ? DAMPED : 1.0) * world->frame.support_radius / dt;
  for (int32_t k = 0; k < fluid->own; k++) {
    const double *v = &fluid->velocity[3 * (size_t)k];
    const double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    if (__builtin_expect(square <= limit * limit, 1)) continue; /* never of what is no number */
    if (isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]))
      hc_fault_note(fault, fast, sqrt(square), fluid->id[k]);
    else
      hc_fault_note(fault, no_number, 0.0, fluid->id[k]);
  }
}

void hc_fault_watch_start(const hc_world *world, double dt, hc_fault *fault) {
  const hc_particles *fluid = world->fluid;
  watch_velocities(world, dt, HC_FAULT_START_VALUE, HC_FAULT_START_SPEED, fault);
  for (int field = 0; field < HC_FIELD_COUNT; field++) { /* what solvers carry from step to step */
    const hc_field_info *info = &hc_fields[field];
    if (!fluid->data[field] || !hc_field_is_state(info) || info->type != HC_TYPE_f32) continue;
    const float *values = fluid->data[field];
    const int components = info->components;
    for (size_t k = 0; k < (size_t)fluid->own * (size_t)components; k++)
      if (!isfinite(values[k]))
        hc_fault_note(fault, HC_FAULT_START_VALUE, 0.0, fluid->id[k / (size_t)components]);
  }
  if (world->list.crowded >= 0) hc_fault_note(fault, HC_FAULT_CROWDED, 0.0, fluid->id[world->list.crowded]);
}

void hc_fault_watch_density(const hc_world *world, hc_fault *fault) {
  const hc_particles *fluid = world->fluid;
  for (int32_t k = 0; k < fluid->own; k++)
    if (!isfinite(fluid->density[k])) hc_fault_note(fault, HC_FAULT_DENSITY, 0.0, fluid->id[k]);
}

void hc_fault_watch_end(const hc_world *world, double dt, hc_fault *fault) {
  const hc_particles *fluid = world->fluid;
  watch_velocities(world, dt, HC_FAULT_VALUE, HC_FAULT_SPEED, fault);
  for (int32_t k = 0; k < fluid->own; k++) {
    if (!isfinite(fluid->pressure[k])) hc_fault_note(fault, HC_FAULT_VALUE, 0.0, fluid->id[k]);
    for (int axis = 0; axis < 3; axis++) {
      const int64_t x = fluid->position[3 * (size_t)k + (size_t)axis];
      if (x > WORLD_END || x < -WORLD_END) hc_fault_note(fault, HC_FAULT_POSITION, 0.0, fluid->id[k]);
    }
  }
}

void hc_fault_watch_fastest(const hc_world *world, hc_fault_kind kind, hc_fault *fault) {
  const hc_particles *fluid = world->fluid;
  for (int32_t k = 0; k < fluid->own; k++) {
    const double *v = &fluid->velocity[3 * (size_t)k];
    hc_fault_note(fault, kind, sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]), fluid->id[k]);
  }
}

static hc_status tell(const hc_fault *fault, double dt, hc_error *error) {
  const long long id = (long long)fault->id;
  switch (fault->kind) {
  case HC_FAULT_NONE:
    break;
  case HC_FAULT_TIME_STEP:
    return hc_error_set(error, HC_FAILED, "the time step, %.3g s, is under its floor", dt);
  case HC_FAULT_START_VALUE:
    return hc_error_set(error, HC_FAILED,
                        "the velocity or pressure of particle %lld was no number as the step began", id);
  case HC_FAULT_CROWDED:
    return hc_error_set(error, HC_FAILED, "more than %d particles lie in one cell with particle %lld",
                        HC_CELL_MOST, id);
  case HC_FAULT_DENSITY:
    return hc_error_set(error, HC_FAILED, "the density of particle %lld is no number", id);
  case HC_FAULT_OWN_STEP:
    return hc_error_set(error, HC_FAILED,
                        "particle %lld asks for a time step of %.3g s, which is under the floor", id,
                        1.0 / fault->value);
  case HC_FAULT_VALUE:
    return hc_error_set(error, HC_FAILED, "the velocity or pressure of particle %lld is no number", id);
  case HC_FAULT_POSITION:
    return hc_error_set(error, HC_FAILED, "particle %lld is beyond all positions there are", id);
  case HC_FAULT_START_SPEED:
  case HC_FAULT_SPEED:
    return hc_error_set(error, HC_FAILED,
                        "particle %lld would move by %.3g m in the step, more than a support radius", id,
                        fault->value * dt);
  case HC_FAULT_ERROR:
    return hc_error_set(error, HC_FAILED,
                        "the density errors are beyond all bounds, and particle %lld is the fastest", id);
  case HC_FAULT_LEFT:
    return hc_error_set(error, HC_FAILED, "particle %lld has left the world's limits", id);
  }
  return HC_OK;
}

hc_status hc_fault_agree(hc_comm *comm, double dt, hc_tally *tally, hc_fault *fault, hc_error *error) {
  int64_t first = fault->kind == HC_FAULT_NONE ? INT64_MIN : -(int64_t)fault->kind; /* the largest */
  hc_tally_max_i64(tally, &first, 1);
  hc_tally_reduce(comm, tally);
  if (first == INT64_MIN) return HC_OK;
  const hc_fault_kind kind = (hc_fault_kind)-first;
  double value = fault->kind == kind ? fault->value : -1.0;
  hc_comm_max_f64(comm, &value, 1);
  int64_t id = fault->kind == kind && fault->value == value ? (int64_t)fault->id : INT64_MAX;
  hc_comm_min_i64(comm, &id, 1);
  *fault = (hc_fault){kind, value, (uint64_t)id};
  return tell(fault, dt, error);
}
