#include "wall_layer.h"

#include "base/clamp.h"
#include "base/logarithm.h"
#include "base/memory.h"
#include "sph/kernel.h"

#include <math.h>
#include <string.h>

static const double VISCOUS_END = 139.5, POWER = 0.0246385; /* of Werner and Wengle */
static const double KARMAN = 0.41, ROUGH = 30.0;
static const double NEAREST = 0.25, FARTHEST = 1.5; /* spacings: bounds of y */

enum { AT_ONCE = 64 }; /* particles whose surroundings are added up together */

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static const hc_wall_friction *friction_of(const hc_sweep *sweep, int32_t b) {
  return &sweep->friction[(int)sweep->boundary->motion[b].scalar];
}

double hc_wall_layer_share(const hc_sweep *sweep, const double d[3], int32_t b) {
  if (!sweep->friction || friction_of(sweep, b)->law == HC_FRICTION_NONE) return 0.0;
  const double square = dot(d, d);
  return square < 1.0 && hc_sweep_over_wall(sweep, b, d) > 0.0 ? hc_kernel_shape(sqrt(square)) : 0.0;
}

/* Shear stress over rest density and velocity, m/s. */
static double stress(const hc_wall_friction *friction, double viscosity, double y, double speed) {
  if (friction->law == HC_FRICTION_NONE) return 0.0;
  const double reach = speed * y / viscosity, laminar = viscosity / y;
  if (friction->law == HC_FRICTION_NO_SLIP) return laminar;
  const double smooth = reach <= VISCOUS_END ? laminar : POWER * speed / sqrt(sqrt(reach));
  if (friction->law == HC_FRICTION_SMOOTH) return smooth;
  const double layers = fmax(1.0, hc_logarithm(ROUGH * y / friction->roughness)), rough = KARMAN / layers;
  return fmax(smooth, rough * rough * speed);
}

/* Of walls with different friction, each as far as it is near. */
static double mean_stress(const hc_sweep *sweep, int32_t i, double viscosity, double y, double speed) {
  if (!sweep->friction_differs) return stress(&sweep->friction[0], viscosity, y, speed);
  const uint32_t *const row = hc_list_row(sweep->walls, i);
  double sum = 0.0, weights = 0.0;
  for (int32_t k = 0; k < hc_list_count(sweep->walls, i); k++) {
    double d[3];
    const int32_t b = (int32_t)(row[k] / sizeof(hc_record));
    hc_sweep_from_wall(sweep, i, b, d);
    const double weight = hc_wall_layer_share(sweep, d, b);
    if (weight > 0.0) sum += weight * stress(friction_of(sweep, b), viscosity, y, speed);
    weights += weight;
  }
  return weights > 0.0 ? sum / weights : 0.0;
}

/* The change of velocity by friction. */
static void rub(const hc_sweep *sweep, int32_t i, const hc_wall_around *around, double viscosity, double dt,
                double change[3]) {
  const double normal[3] = {around->normal[0], around->normal[1], around->normal[2]};
  const double area[3] = {around->area[0], around->area[1], around->area[2]};
  const double length = sqrt(dot(normal, normal)), weight = (double)around->weight;
  if (!(weight > 0.0 && length > 0.0)) return;
  const double *const velocity = &sweep->fluid->velocity[3 * (size_t)i];
  const double spacing = 2.0 * (double)sweep->wall_offset * (double)sweep->support;
  double u[3], along = 0.0;
  for (int axis = 0; axis < 3; axis++) {
    u[axis] = velocity[axis] - (double)around->velocity[axis] / weight;
    along += u[axis] * normal[axis] / length;
  }
  for (int axis = 0; axis < 3; axis++) u[axis] -= along * normal[axis] / length;
  const double speed = sqrt(dot(u, u));
  if (speed == 0.0) return;
  const double over = (double)sweep->support * (double)around->height / weight - 0.5 * spacing,
               y = hc_clamp(over, NEAREST * spacing, FARTHEST * spacing),
               a = 2.0 * (double)sweep->volume * sqrt(dot(area, area)),
               drag = dt * a * mean_stress(sweep, i, viscosity, y, speed);
  for (int axis = 0; axis < 3; axis++) change[axis] = -u[axis] * drag / (1.0 + drag);
}

/* What of the pull acts behind the wetted surface, m/s2: there the pressure changes as in the fluid, whose
 * pressure gradient holds it against what it does not fall by. */
static void find_depth(const hc_world *world, const hc_solver_settings *settings, float pressure, int32_t i,
                       float depth[3]) {
  double g[3];
  memset(depth, 0, 3 * sizeof *depth);
  if (!(pressure > 0.0f)) return;
  hc_body_force(world, settings, i, g);
  const double pull = sqrt(dot(g, g));
  if (!(pull > 0.0)) return;
  const double spacing = 2.0 * (double)world->sweep.wall_offset * (double)world->sweep.support,
               share = hc_clamp((double)pressure / ((double)world->sweep.rest_density * pull * spacing), 0.0,
                                1.0),
               borne = hc_clamp((double)world->fluid->borne[i], 0.0, 1.0);
  for (int axis = 0; axis < 3; axis++) depth[axis] = (float)(share * borne * g[axis]);
}

void hc_wall_layer_list(hc_world *world, bool depth) {
  hc_touches *const touches = &world->touches;
  touches->count = 0;
  if (!world->sweep.friction && !depth) return;
  for (int32_t i = 0; i < world->fluid->own; i++) {
    if (hc_list_count(&world->walls, i) == 0) continue;
    if (touches->count == touches->room)
      hc_reserve((void **)&touches->at, &touches->room, 2 * touches->count + 64, touches->count,
                 sizeof *touches->at);
    touches->at[touches->count++] = (hc_touch){.particle = i};
  }
}

void hc_wall_layer_look(hc_world *world, const hc_solver_settings *settings, const float *pressure) {
  hc_touches *const touches = &world->touches;
  hc_wall_layer_list(world, pressure != NULL);
  for (size_t k = 0; k < touches->count && pressure; k++)
    find_depth(world, settings, pressure[touches->at[k].particle], touches->at[k].particle,
               touches->at[k].depth);
}

/* What walls change a particle's velocity by over dt. */
static void find_change(const hc_world *world, const hc_wall_around *around, double viscosity, double dt,
                        hc_touch *touch, double change[3]) {
  memset(change, 0, 3 * sizeof *change);
  rub(&world->sweep, touch->particle, around, viscosity, dt, change);
  for (int axis = 0; axis < 3; axis++) {
    touch->rub[axis] = (float)change[axis];
    change[axis] -= dt * (double)around->depth[axis];
  }
}

static void act_on(hc_world *world, int32_t i, const double change[3]) {
  hc_particles *const fluid = world->fluid;
  for (int axis = 0; axis < 3; axis++) {
    double *const velocity = &fluid->velocity[3 * (size_t)i + (size_t)axis];
    *velocity += change[axis];
    fluid->motion[i].v[axis] = (float)*velocity;
  }
}

/* The first touch at or behind `first` of a particle that is not before i. */
static size_t next_touch(const hc_touches *touches, size_t first, int32_t i) {
  while (first < touches->count && touches->at[first].particle < i) first++;
  return first;
}

void hc_wall_layer_act(hc_world *world, const hc_solver_settings *settings, double dt, int32_t begin,
                       int32_t end) {
  const hc_touches *const touches = &world->touches;
  hc_wall_around around[AT_ONCE];
  size_t first = next_touch(touches, 0, begin);
  while (first < touches->count && touches->at[first].particle < end) {
    int32_t count = 0;
    while (count < AT_ONCE && first + (size_t)count < touches->count &&
           touches->at[first + (size_t)count].particle < end)
      count++;
    world->sweeps->wall_layer(&world->sweep, &touches->at[first], count, around);
    for (int32_t k = 0; k < count; k++) {
      hc_touch *const touch = &touches->at[first + (size_t)k];
      double change[3];
      find_change(world, &around[k], settings->kinematic_viscosity, dt, touch, change);
      act_on(world, touch->particle, change);
    }
    first += (size_t)count;
  }
}

void hc_wall_layer_add(hc_world *world, const hc_solver_settings *settings, double dt, float *change,
                       hc_selection selection) {
  const hc_touches *const touches = &world->touches;
  hc_wall_around around[AT_ONCE];
  hc_touch some[AT_ONCE];
  size_t at[AT_ONCE], next = 0;
  int32_t row = selection.begin;
  while (row < selection.end) {
    int32_t count = 0;
    for (; row < selection.end && count < AT_ONCE; row++) {
      const int32_t i = hc_selected(selection, row);
      next = next_touch(touches, next, i);
      if (next == touches->count) row = selection.end - 1;
      if (next == touches->count || touches->at[next].particle != i) continue;
      some[count] = touches->at[next];
      if (settings->depth_pressure)
        find_depth(world, settings, world->fluid->pressure[i], i, some[count].depth);
      at[count++] = next++;
    }
    world->sweeps->wall_layer(&world->sweep, some, count, around);
    for (int32_t k = 0; k < count; k++) {
      double of_walls[3];
      find_change(world, &around[k], settings->kinematic_viscosity, dt, &some[k], of_walls);
      touches->at[at[k]] = some[k];
      for (int axis = 0; axis < 3; axis++)
        change[3 * (size_t)some[k].particle + (size_t)axis] += (float)of_walls[axis];
    }
  }
}

void hc_wall_layer_shorten(hc_world *world, double share) {
  hc_touches *const touches = &world->touches;
  for (size_t k = 0; k < touches->count; k++)
    for (int axis = 0; axis < 3; axis++) touches->at[k].rub[axis] *= (float)share;
}
