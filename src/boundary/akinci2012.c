/* Akinci, Ihmsen, Akinci, Solenthaler, Teschner 2012, "Versatile rigid-fluid coupling for incompressible
 * SPH".
 *
 * A boundary particle stands for the volume V_b = factor / sum W, the sum over boundary particles only. The
 * paper's factor is 1, which over-counts a flat wall; the scene's default is computed so that a resting
 * lattice one spacing from a flat wall has exactly the rest density (setup/rest_lattice.h). The wall's push
 * enters the pressure sweep through wall_gradient.
 *
 * Squared (not in the paper). A fluid neighbour pushes with p_i + p_j, a wall that mirrors the pressure with
 * p_i once: to hold the water the layer at a wall must have twice its pressure. Where the wall density goes
 * with the square of N = sum V_b W n_b (sph/sweeps.h, pairs.h) its gradient is twice as steep at a spacing,
 * and still the exact gradient of what is kept at rest density, so that no energy comes from nowhere. Then
 * the first layer has the pressure of its depth, to a few percent. solver/wall_layer.h gives the pressure
 * behind the surface what it gains by depth.
 *
 * Contact. A single layer weighs as much as one layer of fluid, so pressure stops a particle only where its
 * density reaches the rest density: a drop of few particles passes through the layer, whose gradient vanishes
 * in the middle. Not in the paper: the part of the velocity along the gradient B of the wall density D_b is
 * cut so that D_b + dt (v . B - sum V_b v_b . grad W), which follows moving walls, stays within the value on
 * the wetted surface of a flat wall (squared: N, from whose value D_b follows); a particle already beyond
 * keeps no approaching velocity, but is not thrown out. Fluid at rest stays a spacing away and never notices.
 *
 * Between walls that meet at an angle a move from one of them into the other is none along B, and at bent
 * ones N is short. So where some sample looks far aside from B, and always where densities are squared, each
 * has a word of its own: a particle may come to the plane half a spacing in front of it, no farther. */
#include "boundary.h"

#include "base/memory.h"
#include "normals.h"
#include "sph/kernel.h"

static const double ASIDE = 0.68;  /* cosine between B and the normal of a sample: walls at an angle */
static const double BESIDE = 0.75; /* spacings: how far beside a sample the plane in front of it reaches */
static const double NEAR = 0.5;    /* of the limit: with less wall density no face can be reached in a step */
enum { PASSES = 2 };               /* over the faces of a particle, which push it to and fro */

static void prepare(const hc_sweeps *sweeps, const hc_sweep *sweep, hc_particles *boundary,
                    const hc_neighbors *list, double factor) {
  sweeps->boundary_volume(sweep, boundary, list, (float)factor);
  if (sweep->flat_wall > 0.0f) hc_boundary_look_at_normals(sweep, boundary, list);
}

/* A particle that may touch walls. */
typedef struct touch {
  const hc_sweep *sweep;
  int32_t i;
  double dt;
  double gradient[3], square; /* B, 1/m; B.B */
  double held[3];             /* m/s, by samples */
} touch;

static void take_out(const touch *t, double speed, const double direction[3]) {
  hc_particles *const fluid = t->sweep->fluid;
  for (int axis = 0; axis < 3; axis++) {
    double *const velocity = &fluid->velocity[3 * (size_t)t->i + (size_t)axis];
    *velocity -= speed * direction[axis];
    fluid->motion[t->i].v[axis] = (float)*velocity;
  }
}

/* The share of walls in a particle's wall density that are too thin for normals. */
static double thin_share(const touch *t, double density) {
  const hc_sweep *const sweep = t->sweep;
  const uint32_t *const row = hc_list_row(sweep->walls, t->i);
  double thin = 0.0;
  for (int32_t k = 0; k < hc_list_count(sweep->walls, t->i); k++) {
    const int32_t b = (int32_t)(row[k] / sizeof(hc_record));
    if (sweep->boundary->facing[b].scalar != 0.0f) continue;
    double d[3];
    hc_sweep_from_wall(sweep, t->i, b, d);
    const double square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    thin += (double)sweep->kernel * (double)sweep->boundary->place[b].scalar * hc_kernel_shape(sqrt(square));
  }
  return fmin(1.0, thin / density);
}

/* How far D_b may rise until the particle is at the wetted surface, where the sum of wall densities is
 * `limit`. Where D_b goes with the square of N, it is N that may come to the limit, and D_b rises by 2 N
 * dN/D_0. */
static double room_of(const touch *t, double density, double limit, double approach) {
  const double flat = (double)t->sweep->flat_wall, of_sum = limit - density;
  if (flat == 0.0) return of_sum;
  const double n = sqrt(density * flat), squared = 2.0 * n / flat * (limit - n);
  if (approach * t->dt <= fmin(of_sum, squared)) return of_sum; /* room enough whichever it is */
  const double share = thin_share(t, density);
  return share * of_sum + (1.0 - share) * squared;
}

/* What would carry the particle further along B than its wall density allows. The push acts like a divergence
 * multiplier: rho0 push/dt in Pa. */
static bool hold_by_density(const touch *t, double density, double limit) {
  const hc_particles *const fluid = t->sweep->fluid;
  const double *const velocity = &fluid->velocity[3 * (size_t)t->i];
  double approach = fluid->wall_rate ? -(double)fluid->wall_rate[t->i] : -0.0;
  for (int axis = 0; axis < 3; axis++) approach += velocity[axis] * t->gradient[axis];
  if (approach <= 0.0) return false;
  const double room = room_of(t, density, limit, approach);
  const double allowed = room > 0.0 ? room / t->dt : 0.0;
  if (approach <= allowed) return false;
  const double push = (approach - allowed) / t->square;
  take_out(t, push, t->gradient);
  fluid->pressure[t->i] += (float)((double)t->sweep->rest_density * push / t->dt);
  return true;
}

/* What would carry it through the plane in front of a sample. */
static bool hold_by_sample(touch *t, int32_t b) {
  const hc_sweep *const sweep = t->sweep;
  const float *const normal = sweep->boundary->facing[b].v, *const wall = sweep->boundary->motion[b].v;
  const double *const velocity = &sweep->fluid->velocity[3 * (size_t)t->i], offset = sweep->wall_offset,
                      reach = 2.0 * BESIDE * offset;
  double height = 0.0, square = 0.0, approach = 0.0, inward[3], d[3];
  hc_sweep_from_wall(sweep, t->i, b, d);
  for (int axis = 0; axis < 3; axis++) {
    const double n = normal[axis];
    height += d[axis] * n;
    square += d[axis] * d[axis];
    approach -= (velocity[axis] - (double)wall[axis]) * n;
    inward[axis] = -n;
  }
  if (height < 0.0 || square - height * height > reach * reach) return false; /* behind it, or beside */
  const double allowed = fmax(0.0, height - offset) * sweep->support / t->dt, speed = approach - allowed;
  if (speed <= 0.0) return false;
  take_out(t, speed, inward);
  for (int axis = 0; axis < 3; axis++) t->held[axis] -= speed * inward[axis];
  return true;
}

/* Does a sample near the particle look far aside from B? */
static bool is_between(const touch *t) {
  const hc_neighbors *const walls = t->sweep->walls;
  const uint32_t *const row = hc_list_row(walls, t->i);
  for (int32_t k = 0; k < hc_list_count(walls, t->i); k++) {
    const float *const n = t->sweep->boundary->facing[row[k] / sizeof(hc_record)].v;
    const double along = -(n[0] * t->gradient[0] + n[1] * t->gradient[1] + n[2] * t->gradient[2]);
    if (along < ASIDE * sqrt(t->square)) return true;
  }
  return false;
}

static bool hold_by_samples(touch *t, hc_holds *holds) {
  const hc_neighbors *const walls = t->sweep->walls;
  const uint32_t *const row = hc_list_row(walls, t->i);
  bool held = false;
  for (int pass = 0; pass < PASSES; pass++)
    for (int32_t k = 0; k < hc_list_count(walls, t->i); k++)
      held |= hold_by_sample(t, (int32_t)(row[k] / sizeof(hc_record)));
  if (!held) return false;
  hc_reserve((void **)&holds->at, &holds->room, 2 * holds->count + 16, holds->count, sizeof *holds->at);
  holds->at[holds->count++] =
      (hc_hold){.particle = t->i, .change = {(float)t->held[0], (float)t->held[1], (float)t->held[2]}};
  return true;
}

static int64_t contact(const hc_sweep *sweep, hc_selection selection, double limit, double dt,
                       const float *shares) {
  const hc_particles *const fluid = sweep->fluid;
  int64_t held = 0;
  for (int32_t row = selection.begin; row < selection.end; row++) {
    const int32_t i = hc_selected(selection, row);
    const double density = (double)fluid->wall_density[i];
    if (density == 0.0) continue; /* no wall near */
    touch t = {.sweep = sweep, .i = i, .dt = shares ? dt * (double)shares[i] : dt};
    for (int axis = 0; axis < 3; axis++) {
      t.gradient[axis] = (double)fluid->wall_gradient[3 * (size_t)i + (size_t)axis];
      t.square += t.gradient[axis] * t.gradient[axis];
    }
    if (t.square == 0.0) continue;
    const bool by_density = hold_by_density(&t, density, limit);
    const bool by_each = sweep->flat_wall > 0.0f || is_between(&t); /* N of a bent wall is short */
    held += (density > NEAR * limit && by_each && hold_by_samples(&t, sweep->holds)) || by_density;
  }
  return held;
}

const hc_boundary_ops hc_boundary_akinci2012 = {"akinci2012", HC_WALLS_MIRRORED, HC_FOR_WALL_VOLUMES,
                                                prepare,      contact,           NULL};
