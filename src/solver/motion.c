/* What every solver does around its pressure: non-pressure forces and the move. */
#include "solver.h"

#include "sph/error_rule.h"

#include "base/clamp.h"
#include "base/memory.h"
#include "particles/ids.h"

#include <math.h>
#include <string.h>

void hc_remember_velocities(hc_world *world) {
  hc_particles *fluid = world->fluid;
  for (int32_t k = 0; k < fluid->own; k++)
    for (int axis = 0; axis < 3; axis++) fluid->acceleration[3 * (size_t)k + axis] = fluid->motion[k].v[axis];
}

double hc_fastest(const hc_particles *fluid) {
  double largest = 0.0;
  for (int32_t k = 0; k < fluid->own; k++) {
    const double *v = &fluid->velocity[3 * (size_t)k];
    largest = fmax(largest, v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  }
  return largest;
}

hc_wall_drag hc_solver_wall_drag(const hc_solver_settings *settings, double support_radius) {
  const double coefficient = settings->viscosity_coefficient;
  if (settings->viscosity == HC_VISCOUS_LAMINAR) return (hc_wall_drag){HC_DRAG_LAMINAR, coefficient};
  if (settings->viscosity != HC_VISCOUS_ARTIFICIAL) return (hc_wall_drag){.kind = HC_DRAG_NONE};
  return (hc_wall_drag){HC_DRAG_ARTIFICIAL, coefficient * support_radius * settings->sound_speed};
}

static void viscous_change(hc_world *world, const hc_solver_settings *settings, double dt, float *change,
                           hc_selection selection) {
  const hc_sweep *sweep = &world->sweep;
  const double h = world->frame.support_radius, coefficient = settings->viscosity_coefficient;
  switch (settings->viscosity) {
  case HC_VISCOUS_NONE:
    for (int32_t row = selection.begin; row < selection.end; row++)
      memset(&change[3 * (size_t)hc_selected(selection, row)], 0, 3 * sizeof *change);
    break;
  case HC_VISCOUS_XSPH:
    world->sweeps->xsph(sweep, (float)coefficient, change, selection);
    break;
  case HC_VISCOUS_LAMINAR:
    world->sweeps->laminar(sweep, (float)(coefficient * dt), change, selection);
    break;
  case HC_VISCOUS_SMAGORINSKY: {
    const hc_eddies eddies = hc_eddies_of(settings->kinematic_viscosity, settings->mixing_length, h, dt);
    world->sweeps->smagorinsky(sweep, &eddies, change, selection);
    break;
  }
  case HC_VISCOUS_ARTIFICIAL:
    world->sweeps->artificial(sweep, (float)(coefficient * h * settings->sound_speed * dt), change,
                              selection);
    break;
  }
}

float *hc_find_forces(hc_world *world, const hc_solver_settings *settings, double dt,
                      const hc_smoothing *smoothed, hc_selection selection) {
  float *change = hc_particles_scratch(world->fluid, 3 * sizeof *change);
  if (!smoothed) viscous_change(world, settings, dt, change, selection);
  if (settings->surface_tension > 0.0)
    world->sweeps->cohesion(&world->sweep, (float)(settings->surface_tension * dt), change, selection);
  return change;
}

hc_smoothing hc_find_forces_ahead(hc_world *world, const hc_solver_settings *settings) {
  if (settings->viscosity != HC_VISCOUS_XSPH) return (hc_smoothing){.change = NULL};
  return (hc_smoothing){(float)settings->viscosity_coefficient,
                        hc_particles_scratch(world->fluid, 3 * sizeof(float))};
}

/* From the centre of the central force to a particle, m; along periodic axes there is no centre. */
static void from_centre(const hc_world *world, const hc_solver_settings *settings, int32_t i, double arm[3]) {
  const hc_frame *frame = &world->frame;
  for (int axis = 0; axis < 3; axis++)
    arm[axis] = frame->period[axis] > 0 ? 0.0
                                        : (double)(world->fluid->position[3 * (size_t)i + (size_t)axis] -
                                                   hc_frame_to_units(frame, axis, settings->centre[axis])) *
                                              frame->unit[axis];
}

void hc_body_force(const hc_world *world, const hc_solver_settings *settings, int32_t i, double force[3]) {
  const double square = settings->central_rate * settings->central_rate;
  double arm[3];
  memcpy(force, settings->gravity, 3 * sizeof *force);
  if (square == 0.0) return;
  from_centre(world, settings, i, arm);
  for (int axis = 0; axis < 3; axis++) force[axis] -= square * arm[axis];
}

void hc_accelerate(hc_world *world, const hc_solver_settings *settings, const float *change, double dt,
                   int32_t begin, int32_t end) {
  hc_particles *fluid = world->fluid;
  for (int32_t k = begin; k < end; k++) {
    double force[3];
    hc_body_force(world, settings, k, force);
    for (int axis = 0; axis < 3; axis++) {
      double *velocity = &fluid->velocity[3 * (size_t)k + axis];
      *velocity += (double)change[3 * (size_t)k + axis] + dt * force[axis];
      fluid->motion[k].v[axis] = (float)*velocity;
    }
  }
}

void hc_hold_still(hc_world *world, int32_t begin, int32_t end) {
  hc_particles *const fluid = world->fluid;
  for (int32_t k = begin; k < end && world->holding; k++) {
    if (hc_id_kind_of(fluid->id[k]) != HC_ID_HELD) continue;
    memset(&fluid->velocity[3 * (size_t)k], 0, 3 * sizeof *fluid->velocity);
    memset(fluid->motion[k].v, 0, sizeof fluid->motion[k].v);
  }
}

double hc_largest_force(const hc_world *world, const hc_solver_settings *settings, double dt,
                        const float *change, const float *push) {
  double largest = 0.0;
  const double rate = 1.0 / dt;
  const bool viscous = (settings->viscosity != HC_VISCOUS_NONE && settings->viscosity != HC_VISCOUS_XSPH) ||
                       settings->surface_tension > 0.0;
  const bool alike = !viscous && !push && settings->central_rate == 0.0;
  const int32_t own = alike ? world->fluid->own > 0 : world->fluid->own;
  for (int32_t k = 0; k < own; k++) {
    double square = 0.0, body[3];
    hc_body_force(world, settings, k, body);
    for (int axis = 0; axis < 3; axis++) {
      const size_t at = 3 * (size_t)k + (size_t)axis;
      const double sum = (viscous ? (double)change[at] : 0.0) + (push ? (double)push[at] : 0.0);
      const double force = body[axis] + sum * rate;
      square += force * force;
    }
    if (square > largest) largest = square;
  }
  return sqrt(largest);
}

/* Turns the remembered velocities into what they are called: a = (v - v remembered)/dt. */
static void find_accelerations(hc_particles *fluid, double dt) {
  const double rate = 1.0 / dt;
  for (size_t k = 0; k < 3 * (size_t)fluid->own; k++)
    fluid->acceleration[k] = (float)((fluid->velocity[k] - (double)fluid->acceleration[k]) * rate);
}

double hc_reduce_errors(hc_comm *comm, const hc_error_total *total, hc_tally *more, double *max) {
  enum { PARTS = 4 };
  const int64_t mask = 0xffffffff;
  int64_t parts[PARTS] = {(int64_t)total->sum & mask, (int64_t)(total->sum >> 32) & mask,
                          (int64_t)(total->sum >> 64), total->not_finite};
  *max = (double)total->max;
  hc_tally alone = {.count = 0}, *const tally = more ? more : &alone;
  hc_tally_sum_i64(tally, parts, PARTS);
  hc_tally_max_f64(tally, max, 1);
  hc_tally_reduce(comm, tally);
  const hc_error_total all = {.sum = (((__int128)parts[2] * 0x100000000 + parts[1]) * 0x100000000) + parts[0],
                              .not_finite = parts[3] > 0};
  const hc_sum sum = hc_error_sum(&all);
  return hc_sum_value(&sum);
}

/* Looks for what must not move; the same on every rank. Contacts are added up with it. */
static hc_status look_before_move(hc_world *world, double dt, bool broken, hc_step_report *report,
                                  hc_error *error) {
  hc_fault_watch_end(world, dt, &report->fault);
  if (broken && report->fault.kind == HC_FAULT_NONE)
    hc_fault_watch_fastest(world, HC_FAULT_ERROR, &report->fault);
  hc_tally tally = {.count = 0};
  hc_tally_sum_i64(&tally, &report->contacts, 1);
  if (hc_fault_agree(world->comm, dt, &tally, &report->fault, error) == HC_OK) return HC_OK;
  find_accelerations(world->fluid, dt);
  return error->status;
}

/* Minus the potential of the central force, of a unit of mass. */
static double central_work(const hc_world *world, const hc_solver_settings *settings, int32_t i) {
  double arm[3];
  if (settings->central_rate == 0.0) return 0.0;
  from_centre(world, settings, i, arm);
  return -0.5 * settings->central_rate * settings->central_rate *
         (arm[0] * arm[0] + arm[1] * arm[1] + arm[2] * arm[2]);
}

/* What of particles' weight the pressure bears is averaged by this. */
typedef struct bearing {
  double g[3], per_square; /* 1/g^2 */
  double share;            /* of a step in the average */
} bearing;

static bearing bearing_of(const hc_world *world, const hc_solver_settings *settings, double dt, int32_t i) {
  bearing bearing;
  hc_body_force(world, settings, i, bearing.g);
  const double *const g = bearing.g, square = g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
  bearing.per_square = square > 0.0 ? 1.0 / square : 0.0;
  bearing.share = square > 0.0 ? dt / (dt + sqrt(world->frame.support_radius / sqrt(square))) : 0.0;
  return bearing;
}

/* Notes (g - a).g/g^2 of a step. */
static void note_borne(const bearing *bearing, const float acceleration[3], float *borne) {
  double fall = 0.0;
  for (int axis = 0; axis < 3; axis++) fall += (double)acceleration[axis] * bearing->g[axis];
  const double now = hc_clamp(1.0 - fall * bearing->per_square, -1.0, 2.0);
  *borne += (float)(bearing->share * (now - (double)*borne));
}

static void move_all(hc_world *world, const hc_solver_settings *settings, double dt, hc_move_to to,
                     hc_moved *moved) {
  hc_particles *fluid = world->fluid;
  const hc_frame *frame = &world->frame;
  const double rate = 1.0 / dt;
  double units_per_speed[3];
  for (int axis = 0; axis < 3; axis++) units_per_speed[axis] = dt / frame->unit[axis];
  bearing bearing = {.per_square = 0.0};
  if (fluid->borne && fluid->own > 0) bearing = bearing_of(world, settings, dt, 0);
  for (int32_t k = 0; k < fluid->own; k++) {
    int64_t *position = &fluid->position[3 * (size_t)k];
    const double *velocity = &fluid->velocity[3 * (size_t)k];
    float *acceleration = &fluid->acceleration[3 * (size_t)k];
    double v2 = 0.0, a2 = 0.0, work = 0.0;
    for (int axis = 0; axis < 3; axis++) {
      const int64_t change =
          to == HC_MOVE_TO_PLACE
              ? (int32_t)((uint32_t)fluid->place[k].x[axis] - (uint32_t)(uint64_t)position[axis])
              : llrint(velocity[axis] * units_per_speed[axis]);
      position[axis] = hc_frame_wrap(frame, axis, position[axis] + change);
      const double a = (velocity[axis] - (double)acceleration[axis]) * rate;
      acceleration[axis] = (float)a;
      v2 += velocity[axis] * velocity[axis];
      a2 += a * a;
      work += settings->gravity[axis] * hc_frame_to_metres(frame, axis, position[axis]);
    }
    work += central_work(world, settings, k);
    if (fluid->borne && settings->central_rate != 0.0) /* else all have the same */
      bearing = bearing_of(world, settings, dt, k);
    if (fluid->borne) note_borne(&bearing, acceleration, &fluid->borne[k]);
    hc_sum_add(&moved->energy[0], v2);
    hc_sum_add(&moved->energy[1], work);
    if (v2 > moved->v2_max) moved->v2_max = v2;
    if (a2 > moved->a2_max) moved->a2_max = a2;
  }
}

hc_status hc_move(hc_world *world, const hc_solver_settings *settings, double dt, hc_move_to to, bool broken,
                  hc_step_report *report, hc_error *error) {
  if (to == HC_MOVE_BY_VELOCITY && world->boundary_ops->contact && world->contact_limit > 0.0) {
    world->holds.count = 0;
    report->contacts = world->boundary_ops->contact(&world->sweep, hc_select_all(world->fluid),
                                                    world->contact_limit, dt, NULL);
  }
  if (look_before_move(world, dt, broken, report, error) != HC_OK) return error->status;
  report->moved = (hc_moved){.force_max = report->force_max};
  move_all(world, settings, dt, to, &report->moved);
  return HC_OK;
}

void hc_move_note(hc_step_report *report, hc_tally *tally) {
  hc_tally_sum_i64(tally, &report->evaluated, 1);
  hc_tally_sum_exact(tally, report->moved.energy, 2);
  hc_tally_max_f64(tally, &report->moved.v2_max, 1);
  hc_tally_max_f64(tally, &report->moved.a2_max, 1);
  hc_tally_max_f64(tally, &report->moved.force_max, 1);
}

void hc_move_report(const hc_world *world, hc_step_report *report) {
  const hc_moved *moved = &report->moved;
  report->kinetic_energy = 0.5 * world->mass * hc_sum_value(&moved->energy[0]);
  report->potential_energy = -world->mass * hc_sum_value(&moved->energy[1]);
  report->v_max = sqrt(moved->v2_max);
  report->a_max = sqrt(moved->a2_max);
  report->force_max = moved->force_max;
}
