#include "wall_layer.h"

#include "base/logarithm.h"
#include "base/memory.h"
#include "sph/kernel.h"

#include <math.h>
#include <string.h>

static const double VISCOUS_END = 139.5, POWER = 0.0246385; /* of Werner and Wengle */
static const double KARMAN = 0.41, ROUGH = 30.0;
static const double NEAREST = 0.25, FARTHEST = 1.5; /* spacings: bounds of y */

/* A particle and its walls. */
typedef struct layer {
  const hc_sweep *sweep;
  const hc_solver_settings *settings;
  int32_t i;
  double weight, height;            /* sums of W and W h, h in support radii */
  double normal[3], velocity[3];    /* sums of W n and W v_b */
  double area[3];                   /* sum of grad W, without its constant */
  double depth[3];                  /* sum of V_b (g.(x_b - x_i)) grad W with what of g acts, m/s2 */
  const hc_wall_friction *friction; /* of the wall met first */
  bool mixed;                       /* and others have another */
} layer;

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static int32_t separation(const hc_sweep *sweep, int32_t i, const uint32_t *offset, double d[3]) {
  const int32_t b = (int32_t)(*offset / sizeof(hc_record));
  for (int axis = 0; axis < 3; axis++)
    d[axis] = (double)(int32_t)((uint32_t)sweep->fluid->place[i].x[axis] -
                                (uint32_t)sweep->boundary->place[b].x[axis]) *
              (double)sweep->scale[axis];
  return b;
}

static const hc_wall_friction *friction_of(const hc_sweep *sweep, int32_t b) {
  return &sweep->friction[(int)sweep->boundary->motion[b].scalar];
}

/* How high a particle is over the plane of a sample, in support radii. */
static double height_over(const hc_sweep *sweep, const double d[3], int32_t b) {
  const float *const n = sweep->boundary->facing[b].v;
  return d[0] * (double)n[0] + d[1] * (double)n[1] + d[2] * (double)n[2];
}

/* W without its constant, of q < 1. */
static double shape(double q) {
  const double outer = 1.0 - q, inner = q < 0.5 ? 0.5 - q : 0.0;
  return 2.0 * outer * outer * outer - 8.0 * inner * inner * inner;
}

double hc_wall_layer_share(const hc_sweep *sweep, const double d[3], int32_t b) {
  if (!sweep->friction || friction_of(sweep, b)->law == HC_FRICTION_NONE) return 0.0;
  const double square = dot(d, d);
  return square < 1.0 && height_over(sweep, d, b) > 0.0 ? shape(sqrt(square)) : 0.0;
}

/* Adds up the samples around; `g`: what of the body force acts, null: nothing. */
static void look_around(layer *l, const double *g) {
  const hc_sweep *const sweep = l->sweep;
  const uint32_t *const row = hc_list_row(sweep->walls, l->i);
  const double per_volume = (double)sweep->gradient * (double)sweep->support;
  for (int32_t k = 0; k < hc_list_count(sweep->walls, l->i); k++) {
    double d[3];
    const int32_t b = separation(sweep, l->i, &row[k], d);
    const double square = dot(d, d);
    if (square >= 1.0) continue;
    const double q = sqrt(square);
    const double slope = hc_kernel_slope_over_q(q);
    if (g) {
      const double factor = -(double)sweep->boundary->place[b].scalar * per_volume * dot(g, d) * slope;
      for (int axis = 0; axis < 3; axis++) l->depth[axis] += factor * d[axis];
    }
    const double height = height_over(sweep, d, b);
    if (!sweep->friction || height <= 0.0) continue;
    const hc_wall_friction *const friction = friction_of(sweep, b);
    if (friction->law == HC_FRICTION_NONE) continue;
    const double weight = shape(q);
    l->mixed |=
        l->friction && (l->friction->law != friction->law || l->friction->roughness != friction->roughness);
    if (!l->friction) l->friction = friction;
    l->weight += weight;
    l->height += weight * height;
    for (int axis = 0; axis < 3; axis++) {
      l->normal[axis] += weight * (double)sweep->boundary->facing[b].v[axis];
      l->velocity[axis] += weight * (double)sweep->boundary->motion[b].v[axis];
      l->area[axis] += slope * d[axis];
    }
  }
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
static double mean_stress(const layer *l, double y, double speed) {
  const hc_sweep *const sweep = l->sweep;
  const double viscosity = l->settings->wall_viscosity;
  if (!l->mixed) return stress(l->friction, viscosity, y, speed);
  const uint32_t *const row = hc_list_row(sweep->walls, l->i);
  double sum = 0.0;
  for (int32_t k = 0; k < hc_list_count(sweep->walls, l->i); k++) {
    double d[3];
    const int32_t b = separation(sweep, l->i, &row[k], d);
    const double weight = hc_wall_layer_share(sweep, d, b);
    if (weight > 0.0) sum += weight * stress(friction_of(sweep, b), viscosity, y, speed);
  }
  return sum / l->weight;
}

/* The change of velocity by friction; false: none. */
static bool rub(const layer *l, double dt, double change[3]) {
  const hc_sweep *const sweep = l->sweep;
  const double length = sqrt(dot(l->normal, l->normal));
  if (!(length > 0.0)) return false;
  const double *const velocity = &sweep->fluid->velocity[3 * (size_t)l->i];
  const double spacing = 2.0 * (double)sweep->wall_offset * (double)sweep->support;
  double u[3], along = 0.0;
  for (int axis = 0; axis < 3; axis++) {
    u[axis] = velocity[axis] - l->velocity[axis] / l->weight;
    along += u[axis] * l->normal[axis] / length;
  }
  for (int axis = 0; axis < 3; axis++) u[axis] -= along * l->normal[axis] / length;
  const double speed = sqrt(dot(u, u));
  if (speed == 0.0) return false;
  const double over = (double)sweep->support * l->height / l->weight - 0.5 * spacing,
               y = fmin(fmax(over, NEAREST * spacing), FARTHEST * spacing),
               a = 2.0 * (double)sweep->volume * (double)sweep->gradient * sqrt(dot(l->area, l->area)),
               drag = dt * a * mean_stress(l, y, speed);
  for (int axis = 0; axis < 3; axis++) change[axis] = -u[axis] * drag / (1.0 + drag);
  return true;
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
               share = fmin(1.0, (double)pressure / ((double)world->sweep.rest_density * pull * spacing)),
               borne = fmin(1.0, fmax(0.0, (double)world->fluid->borne[i]));
  for (int axis = 0; axis < 3; axis++) depth[axis] = (float)(share * borne * g[axis]);
}

void hc_wall_layer_look(hc_world *world, const hc_solver_settings *settings, const float *pressure) {
  hc_touches *const touches = &world->touches;
  touches->count = 0;
  if (!world->sweep.friction && !pressure) return;
  for (int32_t i = 0; i < world->fluid->own; i++) {
    if (hc_list_count(&world->walls, i) == 0) continue;
    if (touches->count == touches->room)
      hc_reserve((void **)&touches->at, &touches->room, 2 * touches->count + 64, touches->count,
                 sizeof *touches->at);
    hc_touch *const touch = &touches->at[touches->count++];
    *touch = (hc_touch){.particle = i};
    if (pressure) find_depth(world, settings, pressure[i], i, touch->depth);
  }
}

static void act_on(hc_world *world, const hc_solver_settings *settings, double dt, hc_touch *touch) {
  hc_particles *const fluid = world->fluid;
  layer l = {.sweep = &world->sweep, .settings = settings, .i = touch->particle};
  double change[3] = {0.0, 0.0, 0.0};
  const double g[3] = {touch->depth[0], touch->depth[1], touch->depth[2]};
  look_around(&l, g[0] != 0.0 || g[1] != 0.0 || g[2] != 0.0 ? g : NULL);
  if (l.weight > 0.0) rub(&l, dt, change);
  for (int axis = 0; axis < 3; axis++) {
    double *const velocity = &fluid->velocity[3 * (size_t)l.i + (size_t)axis];
    touch->rub[axis] = (float)change[axis];
    *velocity += change[axis] - dt * l.depth[axis];
    fluid->motion[l.i].v[axis] = (float)*velocity;
  }
}

void hc_wall_layer_act(hc_world *world, const hc_solver_settings *settings, double dt, int32_t begin,
                       int32_t end) {
  const hc_touches *const touches = &world->touches;
  for (size_t k = 0; k < touches->count; k++)
    if (touches->at[k].particle >= begin && touches->at[k].particle < end)
      act_on(world, settings, dt, &touches->at[k]);
}
