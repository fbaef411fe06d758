#include "gauges.h"

#include "base/memory.h"
#include "heights.h"
#include "measures.h"
#include "solver/wall_force.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The most that a reading of a gauge takes over the ranks; the compiler warns of a constant index beyond. */
enum { READING_SUMS = 2 };

static int columns_of(hc_gauge_type type) {
  const char *const *const parts = hc_scene_gauge_parts(type);
  int count = 0;
  while (parts[count]) count++;
  return count > 0 ? count : 1;
}

int hc_gauges_columns(const hc_scene *scene) {
  int columns = 0;
  for (int g = 0; g < scene->output.gauge_count; g++) columns += columns_of(scene->output.gauges[g].type);
  return columns;
}

void hc_gauges_column_name(const hc_scene *scene, int column, char *name, size_t size) {
  const hc_scene_gauge *gauge = scene->output.gauges;
  while (column >= columns_of(gauge->type)) column -= columns_of(gauge++->type);
  const char *const *const parts = hc_scene_gauge_parts(gauge->type);
  if (parts[0])
    snprintf(name, size, "%s_%s", gauge->name, parts[column]);
  else
    snprintf(name, size, "%s", gauge->name);
}

static bool has_moving_mean(const hc_gauges *gauges, int g) {
  return gauges->scene->output.gauges[g].mean_over > 0.0;
}

static bool pushes_wall(const hc_gauges *gauges, int g) {
  return gauges->state[g].wall >= 0;
}

/* How many sums over the ranks a step of a gauge takes: force and moment; a force; sum p W and sum W; a
 * count. */
static int sums_of(const hc_gauges *gauges, int g) {
  switch (gauges->scene->output.gauges[g].type) {
  case HC_GAUGE_FORCE:
    return 6;
  case HC_GAUGE_PRESSURE:
    return pushes_wall(gauges, g) ? 3 : 2;
  case HC_GAUGE_FLOW:
    return 1;
  default:
    return 0;
  }
}

void hc_gauges_init(hc_gauges *gauges, hc_comm *comm, const hc_scene *scene, const hc_frame *frame,
                    const hc_movers *movers, const hc_bodies *bodies, double mass) {
  const int count = scene->output.gauge_count;
  *gauges = (hc_gauges){.scene = scene,
                        .frame = frame,
                        .movers = movers,
                        .bodies = bodies,
                        .comm = comm,
                        .state = hc_alloc_zero((size_t)count, sizeof(hc_gauge_state)),
                        .mass = mass};
  for (int g = 0; g < count; g++) {
    const hc_scene_gauge *gauge = &scene->output.gauges[g];
    gauges->state[g].wall = hc_scene_surface_named(scene, gauge->wall);
    gauges->state[g].body = hc_bodies_of(bodies, hc_scene_surface_named(scene, gauge->body));
    gauges->state[g].radius = gauge->radius > 0.0 ? gauge->radius : frame->support_radius;
    hc_measure_stand(scene, gauge, gauges->state[g].at, gauges->state[g].direction);
    if (has_moving_mean(gauges, g))
      hc_moving_mean_init(&gauges->state[g].moving, gauge->mean_over, columns_of(gauge->type));
    gauges->state[g].first_sum = gauges->sum_count;
    gauges->sum_count += sums_of(gauges, g);
  }
  gauges->sums = hc_alloc_zero((size_t)gauges->sum_count, sizeof *gauges->sums);
}

void hc_gauges_register(hc_gauges *gauges, hc_state *state) {
  hc_state_add(state, HC_TYPE_f64, 1, &gauges->elapsed, "gauges.elapsed");
  for (int g = 0; g < gauges->scene->output.gauge_count; g++) {
    hc_gauge_state *const gauge = &gauges->state[g];
    hc_state_add(state, HC_TYPE_f64, HC_GAUGE_COLUMNS, gauge->integral, "gauges.%d.integral", g);
    if (has_moving_mean(gauges, g)) hc_moving_mean_register(&gauge->moving, state, g);
  }
}

hc_status hc_gauges_find_walls(hc_gauges *gauges, const hc_particles *boundary, hc_error *error) {
  for (int g = 0; g < gauges->scene->output.gauge_count; g++) {
    const hc_scene_gauge *gauge = &gauges->scene->output.gauges[g];
    if (gauge->type != HC_GAUGE_PRESSURE || gauges->state[g].wall < 0) continue;
    hc_sum area;
    memset(&area, 0, sizeof area);
    hc_measure_patch_area(gauges, g, boundary, &area);
    hc_comm_sum_exact(gauges->comm, &area, 1);
    gauges->state[g].area = hc_sum_value(&area);
    if (gauges->state[g].area == 0.0)
      return hc_error_set(
          error, HC_BAD_INPUT,
          "output.gauges[%d] %s: wall '%s' has no sample within the radius (%g m) of (%g, %g, %g) m", g,
          gauge->name, gauge->wall, gauges->state[g].radius, gauge->at[0], gauge->at[1], gauge->at[2]);
  }
  return HC_OK;
}

void hc_gauges_free(hc_gauges *gauges) {
  for (int g = 0; g < gauges->scene->output.gauge_count; g++) hc_moving_mean_free(&gauges->state[g].moving);
  hc_free(gauges->state);
  hc_free(gauges->sums);
  memset(gauges, 0, sizeof *gauges);
}

/* What a gauge of a body averages, over a step. */
static void integrate_body(const hc_gauges *gauges, int g, double dt, double integral[HC_GAUGE_COLUMNS]) {
  const hc_scene_gauge *const gauge = &gauges->scene->output.gauges[g];
  const hc_body *const body = gauges->state[g].body;
  if (gauge->type == HC_GAUGE_MOORING)
    integral[0] = dt * hc_body_tension(gauges->bodies, body, gauge->mooring);
  else
    for (int k = 0; k < HC_GAUGE_COLUMNS; k++) integral[k] = dt * body->load[k];
}

/* What a step's sums mean: the integral over the step of each column of a gauge. */
static void integrate(const hc_gauges *gauges, int g, double dt, double integral[HC_GAUGE_COLUMNS]) {
  const hc_gauge_state *state = &gauges->state[g];
  const hc_sum *sums = gauges->sums + state->first_sum;
  double value[HC_GAUGE_COLUMNS];
  for (int k = 0; k < sums_of(gauges, g); k++) value[k] = hc_sum_value(&sums[k]);
  switch (gauges->scene->output.gauges[g].type) {
  case HC_GAUGE_FORCE:
    for (int k = 0; k < HC_GAUGE_COLUMNS; k++) integral[k] = dt * value[k];
    break;
  case HC_GAUGE_PRESSURE:
    if (pushes_wall(gauges, g)) {
      const double *const d = state->direction;
      const double along = value[0] * d[0] + value[1] * d[1] + value[2] * d[2];
      const double push = d[0] != 0.0 || d[1] != 0.0 || d[2] != 0.0
                              ? along
                              : sqrt(value[0] * value[0] + value[1] * value[1] + value[2] * value[2]);
      if (state->area > 0.0) integral[0] = dt * (push / state->area);
    } else if (value[1] > 0.0) {
      integral[0] = dt * (value[0] / value[1]);
    }
    break;
  case HC_GAUGE_BODY:
  case HC_GAUGE_MOORING:
    integrate_body(gauges, g, dt, integral);
    break;
  case HC_GAUGE_FLOW: /* particles */
    integral[0] = value[0] * (gauges->mass / gauges->scene->fluid.rest_density);
    break;
  default:
    break;
  }
}

/* Puts a gauge where its wall has taken it; `ahead`, s, later. */
static void stand_on_wall(hc_gauges *gauges, int g, double ahead) {
  hc_gauge_state *const state = &gauges->state[g];
  hc_measure_stand(gauges->scene, &gauges->scene->output.gauges[g], state->at, state->direction);
  hc_movers_carry(gauges->movers, gauges->frame, state->wall, ahead, state->at, state->direction);
}

void hc_gauges_note(hc_gauges *gauges, const hc_sweep *sweep, double dt, hc_tally *tally) {
  const hc_scene *scene = gauges->scene;
  bool pushed = false;
  memset(gauges->sums, 0, (size_t)gauges->sum_count * sizeof *gauges->sums);
  for (int g = 0; g < scene->output.gauge_count; g++) {
    const hc_scene_gauge *gauge = &scene->output.gauges[g];
    hc_sum *own = gauges->sums + gauges->state[g].first_sum;
    if (pushes_wall(gauges, g)) stand_on_wall(gauges, g, hc_wall_force_later(sweep, dt));
    pushed |= pushes_wall(gauges, g);
    if (gauge->type == HC_GAUGE_PRESSURE && !pushes_wall(gauges, g))
      hc_measure_point_pressure(gauges, g, sweep->fluid, own);
    if (gauge->type == HC_GAUGE_FLOW)
      hc_sum_add(own, (double)hc_measure_crossings(gauges, gauge, sweep->fluid, dt));
  }
  if (pushed) hc_measure_wall_push(gauges, sweep, dt, gauges->sums);
  hc_tally_sum_exact(tally, gauges->sums, gauges->sum_count);
}

void hc_gauges_step(hc_gauges *gauges, double dt) {
  gauges->elapsed += dt;
  for (int g = 0; g < gauges->scene->output.gauge_count; g++) {
    hc_gauge_state *const state = &gauges->state[g];
    double integral[HC_GAUGE_COLUMNS] = {0.0};
    integrate(gauges, g, dt, integral);
    if (has_moving_mean(gauges, g))
      hc_moving_mean_add(&state->moving, dt, integral);
    else
      for (int k = 0; k < HC_GAUGE_COLUMNS; k++) state->integral[k] += integral[k];
  }
}

/* ---- readings of the moment ---- */

/* What all readings together need of all ranks. */
typedef struct readings {
  hc_sum (*sums)[READING_SUMS]; /* of each gauge */
  double *fronts;               /* of each gauge, along its axis, m; -INFINITY: no water */
  hc_marks marks;               /* of all heights */
} readings;

static double find_front(const hc_gauges *gauges, const hc_scene_gauge *gauge, const hc_particles *fluid) {
  int sign;
  const int axis = hc_measure_axis(gauge, &sign);
  double farthest = -INFINITY, x[3];
  for (int32_t i = 0; i < fluid->own; i++)
    if (hc_measure_in_box(gauge, gauges->frame, &fluid->position[3 * (size_t)i], x))
      farthest = fmax(farthest, sign * x[axis]);
  return farthest;
}

static double front(const hc_gauges *gauges, const hc_scene_gauge *gauge, double farthest) {
  int sign;
  hc_measure_axis(gauge, &sign);
  return farthest == -INFINITY ? NAN : sign * (farthest + 0.5 * gauges->scene->particle_spacing);
}

static void add_energy(const hc_gauges *gauges, int g, const hc_particles *fluid, readings *r) {
  const hc_scene_gauge *const gauge = &gauges->scene->output.gauges[g];
  for (int32_t i = 0; i < fluid->own; i++) {
    const int64_t *position = &fluid->position[3 * (size_t)i];
    double x[3], depth = 0.0;
    if (!hc_measure_in_box(gauge, gauges->frame, position, x)) continue;
    const double *v = &fluid->velocity[3 * (size_t)i];
    for (int axis = 0; axis < 3; axis++) depth += gauges->scene->gravity[axis] * x[axis];
    hc_sum_add(&r->sums[g][0], v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    hc_sum_add(&r->sums[g][1], depth);
  }
}

static void add_volume(const hc_gauges *gauges, int g, const hc_particles *fluid, readings *r) {
  const hc_scene_gauge *const gauge = &gauges->scene->output.gauges[g];
  double x[3];
  for (int32_t i = 0; i < fluid->own; i++)
    if (hc_measure_in_box(gauge, gauges->frame, &fluid->position[3 * (size_t)i], x))
      hc_sum_add(&r->sums[g][0],
                 gauges->mass / fmax((double)fluid->density[i], gauges->scene->fluid.rest_density));
}

static void add_density(const hc_gauges *gauges, int g, const hc_particles *fluid, readings *r) {
  const hc_scene_gauge *const gauge = &gauges->scene->output.gauges[g];
  double x[3];
  for (int32_t i = 0; i < fluid->own; i++)
    if (hc_measure_in_box(gauge, gauges->frame, &fluid->position[3 * (size_t)i], x)) {
      hc_sum_add(&r->sums[g][0], (double)fluid->density[i]);
      hc_sum_add(&r->sums[g][1], 1.0);
    }
}

static void take_readings(const hc_gauges *gauges, const hc_particles *fluid, readings *r) {
  const hc_scene *scene = gauges->scene;
  const int count = scene->output.gauge_count;
  bool heights = false;
  for (int g = 0; g < count; g++) {
    const hc_scene_gauge *gauge = &scene->output.gauges[g];
    heights |= gauge->type == HC_GAUGE_HEIGHT;
    if (gauge->type == HC_GAUGE_HEIGHT) hc_heights_mark(gauges, g, fluid, &r->marks);
    if (gauge->type == HC_GAUGE_FRONT) r->fronts[g] = find_front(gauges, gauge, fluid);
    if (gauge->type == HC_GAUGE_ENERGY) add_energy(gauges, g, fluid, r);
    if (gauge->type == HC_GAUGE_VOLUME) add_volume(gauges, g, fluid, r);
    if (gauge->type == HC_GAUGE_DENSITY) add_density(gauges, g, fluid, r);
  }
  hc_tally tally = {.count = 0};
  hc_tally_sum_exact(&tally, *r->sums, READING_SUMS * count);
  hc_tally_max_f64(&tally, r->fronts, count);
  hc_tally_reduce(gauges->comm, &tally);
  if (heights) hc_heights_gather(gauges->comm, &r->marks);
}

/* Where a body is and how it moves: the columns before its forces. */
enum { BODY_POSE = 12 };

static void tell_body(const hc_gauges *gauges, const hc_body *body, double values[BODY_POSE]) {
  for (int axis = 0; axis < 3; axis++) {
    values[axis] = hc_frame_to_metres(gauges->frame, axis, body->position[axis]);
    values[6 + axis] = body->velocity[axis];
  }
  hc_body_angles(body, values + 3);
  hc_body_spin(body, values + 9);
}

/* A gauge's columns; begins its averages since the last reading anew. */
static void tell(hc_gauges *gauges, int g, const readings *r, double *values) {
  const hc_scene_gauge *gauge = &gauges->scene->output.gauges[g];
  hc_gauge_state *state = &gauges->state[g];
  switch (gauge->type) {
  case HC_GAUGE_HEIGHT:
    values[0] = hc_heights_wet(gauges, g, &r->marks);
    break;
  case HC_GAUGE_FRONT:
    values[0] = front(gauges, gauge, r->fronts[g]);
    break;
  case HC_GAUGE_ENERGY:
    values[0] = 0.5 * gauges->mass * hc_sum_value(&r->sums[g][0]);
    values[1] = -gauges->mass * hc_sum_value(&r->sums[g][1]);
    break;
  case HC_GAUGE_VOLUME:
    values[0] = hc_sum_value(&r->sums[g][0]);
    break;
  case HC_GAUGE_DENSITY: /* 0/0 where there is no water */
    values[0] = hc_sum_value(&r->sums[g][0]) / hc_sum_value(&r->sums[g][1]);
    break;
  case HC_GAUGE_BODY:
    tell_body(gauges, state->body, values);
    for (int k = 0; k < HC_GAUGE_COLUMNS; k++)
      values[BODY_POSE + k] = gauges->elapsed > 0.0 ? state->integral[k] / gauges->elapsed : 0.0;
    memset(state->integral, 0, sizeof state->integral);
    break;
  case HC_GAUGE_PRESSURE:
  case HC_GAUGE_FLOW:
  case HC_GAUGE_FORCE:
  case HC_GAUGE_MOORING:
    if (has_moving_mean(gauges, g)) {
      hc_moving_mean_read(&state->moving, values);
      break;
    }
    for (int k = 0; k < columns_of(gauge->type); k++)
      values[k] = gauges->elapsed > 0.0 ? state->integral[k] / gauges->elapsed : 0.0;
    memset(state->integral, 0, sizeof state->integral);
    break;
  }
}

void hc_gauges_read(hc_gauges *gauges, const hc_particles *fluid, double *values) {
  const int count = gauges->scene->output.gauge_count;
  readings r = {.sums = hc_alloc_zero((size_t)count, sizeof *r.sums),
                .fronts = hc_alloc_zero((size_t)count, sizeof *r.fronts)};
  take_readings(gauges, fluid, &r);
  for (int g = 0; g < count; g++) {
    tell(gauges, g, &r, values);
    values += columns_of(gauges->scene->output.gauges[g].type);
  }
  hc_free(r.sums);
  hc_free(r.fronts);
  hc_free(r.marks.at);
  gauges->elapsed = 0.0;
}
