/* The pair sweeps against plain double-precision sums over all pairs, for every instruction set; and what
 * must hold of them whatever the numbers are. */
#include "cloud.h"
#include "sph/error_rule.h"

#include <check.h>

static vec velocity(const setting *s, int32_t i) {
  vec v;
  for (int axis = 0; axis < 3; axis++) v.x[axis] = velocity_of(s->fluid.id[i], axis);
  return v;
}

/* Of fluid particle i relative to a boundary particle. */
static vec relative_to_wall(const setting *s, int32_t i, int32_t b) {
  vec v = velocity(s, i);
  for (int axis = 0; axis < 3 && s->sweep.walls_move; axis++)
    v.x[axis] -= wall_velocity_of(s->boundary.id[b], axis);
  return v;
}

/* A sum and the sum of its terms' magnitudes. */
typedef struct scaled {
  double value, scale;
} scaled;
typedef struct scaled_vec {
  vec value;
  double scale;
} scaled_vec;

static void add_term(scaled_vec *sum, double factor, vec a) {
  add(&sum->value, factor, a);
  sum->scale += fabs(factor) * norm(a);
}

/* What every sweep should find for one particle. */
typedef struct expected {
  double relative_density, wall_density, inverse_alpha, inverse_alpha_scale;
  scaled rate;
  scaled_vec wall_gradient, pressure, xsph, laminar, smagorinsky, artificial, cohesion;
} expected;

static double relative_density(const setting *s, int32_t i) {
  double sum = 0;
  for (int32_t j = 0; j < s->fluid.own; j++)
    sum += VOLUME * kernel(norm(separation(s, &s->fluid, i, &s->fluid, j)));
  for (int32_t b = 0; b < s->boundary.own; b++)
    sum += boundary_volume_of(s->boundary.id[b]) * kernel(norm(separation(s, &s->fluid, i, &s->boundary, b)));
  return sum;
}

static const double *densities;                                                         /* of all particles */
static const hc_eddies EDDIES = {.molecular = 0.002f, .scale = 0.005f, .most = 0.011f}; /* some at the most */

static expected expect(const setting *s, int32_t i) {
  expected e;
  memset(&e, 0, sizeof e);
  e.relative_density = densities[i];
  const vec vi = velocity(s, i);
  const double ki = kappa_of(s->fluid.id[i]);
  scaled_vec sum = {{{0, 0, 0}}, 0};
  double squares = 0;
  for (int32_t j = 0; j < s->fluid.own; j++) {
    const vec x = separation(s, &s->fluid, i, &s->fluid, j), g = gradient(x);
    const double r = norm(x), soft = r * r + 0.0025 * H * H, kj = kappa_of(s->fluid.id[j]);
    if (j == i || r >= H) continue;
    vec v = vi;
    add(&v, -1, velocity(s, j));
    add_term(&sum, VOLUME, g);
    squares += VOLUME * VOLUME * dot(g, g);
    e.rate.value += VOLUME * dot(v, g);
    e.rate.scale += VOLUME * norm(v) * norm(g);
    add_term(&e.pressure, -VOLUME * (ki + kj), g);
    e.pressure.scale += VOLUME * (fabs(ki) + fabs(kj)) * norm(g);
    add_term(&e.xsph, -VOLUME * (1 / densities[i] + 1 / densities[j]) / 2 * kernel(r), v);
    add_term(&e.laminar, VOLUME * 2 * dot(x, g) / soft, v);
    const double eddies = fmin((double)EDDIES.scale * norm(v) * H / sqrt(soft), (double)EDDIES.most);
    add_term(&e.smagorinsky, VOLUME * 2 * dot(x, g) / soft * ((double)EDDIES.molecular + eddies) * H * H, v);
    add_term(&e.cohesion, -kernel(r), x);
    add_term(&e.artificial, VOLUME * fmin(0, dot(v, x)) / soft, g);
    e.artificial.scale += VOLUME * norm(v) * r / soft * norm(g);
  }
  for (int32_t b = 0; b < s->boundary.own; b++) {
    const vec x = separation(s, &s->fluid, i, &s->boundary, b), g = gradient(x);
    const double r = norm(x), soft = r * r + 0.0025 * H * H, volume = boundary_volume_of(s->boundary.id[b]);
    if (r >= H) continue;
    e.wall_density += volume * kernel(r);
    add_term(&e.wall_gradient, volume, g);
    const vec v = relative_to_wall(s, i, b);
    add_term(&e.artificial, volume * fmin(0, dot(v, x)) / soft, g);
    e.artificial.scale += volume * norm(v) * r / soft * norm(g);
    e.rate.value += volume * (dot(v, g) - dot(vi, g));
    e.rate.scale += volume * (norm(v) + norm(vi)) * norm(g);
  }
  const double steepness = norm(e.wall_gradient.value), behind = (double)s->sweep.wall_offset * H;
  for (int32_t b = 0; b < s->boundary.own; b++) {
    const vec x = separation(s, &s->fluid, i, &s->boundary, b), g = gradient(x);
    const double r = norm(x), soft = r * r + 0.0025 * H * H, volume = boundary_volume_of(s->boundary.id[b]);
    if (r >= H) continue;
    const double distance = steepness > 0 ? fabs(dot(e.wall_gradient.value, x)) / steepness : 0;
    const double goes_on = 1 + behind / fmax(distance - behind, behind); /* beyond the surface */
    add_term(&e.laminar, goes_on * volume * 2 * dot(x, g) / soft, relative_to_wall(s, i, b));
  }
  e.rate.value += dot(vi, e.wall_gradient.value);
  e.rate.scale += norm(vi) * e.wall_gradient.scale;
  add_term(&e.pressure, -ki, e.wall_gradient.value);
  e.pressure.scale += fabs(ki) * e.wall_gradient.scale;
  add_term(&sum, 1, e.wall_gradient.value);
  e.inverse_alpha = dot(sum.value, sum.value) + squares;
  e.inverse_alpha_scale = (sum.scale + e.wall_gradient.scale) * (sum.scale + e.wall_gradient.scale) + squares;
  return e;
}

/* ---- what the sweeps find ---- */

enum { MOST = 700 };

typedef struct found {
  float density[MOST], inverse_density[MOST], wall_density[MOST], rate[MOST], alpha[MOST],
      wall_gradient[MOST][3], kappa[2][MOST];
  hc_sum total[2];
  float max[2];
  float xsph[MOST][3], laminar[MOST][3], smagorinsky[MOST][3], artificial[MOST][3],
      tense[MOST][3]; /* cohesion on xsph */
  double velocity[MOST][3];
  float moved[MOST][3], multiplier[MOST];
} found;

static const hc_error_rule rules[2] = {
    {.of_density = 1.0f, .of_rate = 0.002f, .min_neighbors = 0, .signed_error = true, .relaxation = 0.5f},
    {.of_density = 0.0f,
     .of_rate = 1.0f,
     .of_gap = 40.0f,
     .min_neighbors = 25,
     .signed_error = false,
     .relaxation = 1.0f}};
static const float XSPH = 0.05f, LAMINAR = 3e-5f, ARTIFICIAL = 2e-4f, PRESSURE = 250.0f, COHESION = 1e-4f;

/* Runs every sweep over all particles, in the ranges between the cuts. */
static void run_all(setting *s, hc_isa isa, const int32_t *cuts, int ranges, found *f) {
  const hc_sweeps *sweeps = hc_sweeps_of(isa);
  hc_particles *fluid = &s->fluid;
  memset(f, 0, sizeof *f);
  set_values(s);
  ck_assert_int_le(fluid->own, MOST);
  for (int r = 0; r < ranges; r++) sweeps->density(&s->sweep, hc_select_range(cuts[r], cuts[r + 1]));
  for (int32_t i = 0; i < fluid->own; i++) f->rate[i] = fluid->place[i].scalar;
  for (int r = 0; r < ranges; r++) {
    sweeps->xsph(&s->sweep, XSPH, &f->xsph[0][0], hc_select_range(cuts[r], cuts[r + 1]));
    sweeps->laminar(&s->sweep, LAMINAR, &f->laminar[0][0], hc_select_range(cuts[r], cuts[r + 1]));
    sweeps->smagorinsky(&s->sweep, &EDDIES, &f->smagorinsky[0][0], hc_select_range(cuts[r], cuts[r + 1]));
    sweeps->xsph(&s->sweep, XSPH, &f->tense[0][0], hc_select_range(cuts[r], cuts[r + 1]));
    sweeps->cohesion(&s->sweep, COHESION, &f->tense[0][0], hc_select_range(cuts[r], cuts[r + 1]));
    sweeps->artificial(&s->sweep, ARTIFICIAL, &f->artificial[0][0], hc_select_range(cuts[r], cuts[r + 1]));
  }
  for (int rule = 0; rule < 2; rule++) {
    hc_error_total total;
    memset(&total, 0, sizeof total);
    for (int r = 0; r < ranges; r++)
      sweeps->error(&s->sweep, &rules[rule], hc_select_range(cuts[r], cuts[r + 1]), &total);
    for (int32_t i = 0; i < fluid->own; i++) f->kappa[rule][i] = fluid->place[i].scalar;
    f->total[rule] = hc_error_sum(&total);
    hc_sum_carry(&f->total[rule]);
    f->max[rule] = total.max;
  }
  for (int32_t i = 0; i < fluid->own; i++) fluid->place[i].scalar = kappa_of(fluid->id[i]);
  for (int r = 0; r < ranges; r++)
    sweeps->pressure(&s->sweep, PRESSURE, fluid->pressure_multiplier, hc_select_range(cuts[r], cuts[r + 1]));
  for (int32_t i = 0; i < fluid->own; i++) {
    f->density[i] = fluid->density[i];
    f->inverse_density[i] = fluid->motion[i].scalar;
    f->wall_density[i] = fluid->wall_density[i];
    f->alpha[i] = fluid->alpha[i];
    f->multiplier[i] = fluid->pressure_multiplier[i];
    memcpy(f->wall_gradient[i], &fluid->wall_gradient[3 * i], sizeof f->wall_gradient[i]);
    memcpy(f->velocity[i], &fluid->velocity[3 * i], sizeof f->velocity[i]);
    memcpy(f->moved[i], fluid->motion[i].v, sizeof f->moved[i]);
  }
}

static bool near_vec(const float *values, double factor, const scaled_vec *reference, double extra) {
  bool good = true;
  for (int axis = 0; axis < 3; axis++)
    good &= fabs(values[axis] - factor * reference->value.x[axis]) <=
            TOLERANCE * fabs(factor) * reference->scale + extra;
  return good;
}

/* The error of a particle as the rule has it, and how far off it may be. */
static scaled expected_error(const setting *s, const expected *e, const hc_error_rule *rule, int32_t i) {
  scaled error = {rule->of_density * (e->relative_density - 1) + rule->of_rate * e->rate.value +
                      rule->of_gap * fmin(0, e->relative_density - 1),
                  TOLERANCE * ((fabsf(rule->of_density) + rule->of_gap) * (e->relative_density + 1) +
                               fabsf(rule->of_rate) * e->rate.scale)};
  if (hc_list_count(&s->list, i) + hc_list_count(&s->walls, i) < rule->min_neighbors) error = (scaled){0, 0};
  if (!rule->signed_error && error.value < 0) error.value = 0;
  return error;
}

static void check_found(const setting *s, const found *f, const expected *all, const char *isa) {
  double sums[2] = {0, 0}, slacks[2] = {0, 0}, largest[2] = {0, 0};
  for (int32_t i = 0; i < s->fluid.own; i++) {
    const expected *e = &all[i];
    ck_assert_msg(fabs(f->density[i] / REST_DENSITY - e->relative_density) <= TOLERANCE * e->relative_density,
                  "%s: density %g, expected %g", isa, f->density[i] / REST_DENSITY, e->relative_density);
    ck_assert(fabs(f->inverse_density[i] * e->relative_density - 1) <= TOLERANCE);
    ck_assert(fabs(f->wall_density[i] - e->wall_density) <= TOLERANCE * fmax(e->wall_density, 0.1));
    ck_assert_msg(fabs(f->rate[i] - e->rate.value) <= TOLERANCE * e->rate.scale, "%s: rate", isa);
    ck_assert_msg(near_vec(f->wall_gradient[i], 1, &e->wall_gradient, 0), "%s: wall gradient", isa);
    if (e->inverse_alpha_scale == 0)
      ck_assert(f->alpha[i] == 0);
    else if (f->alpha[i] != 0)
      ck_assert_msg(fabs(1 / (double)f->alpha[i] - e->inverse_alpha) <= TOLERANCE * e->inverse_alpha_scale,
                    "%s: alpha %g, expected %g", isa, f->alpha[i], 1 / e->inverse_alpha);
    else
      ck_assert(e->inverse_alpha < 2e-5 / (H * H));
    ck_assert_msg(near_vec(f->xsph[i], XSPH, &e->xsph, 0), "%s: xsph", isa);
    ck_assert_msg(near_vec(f->laminar[i], LAMINAR, &e->laminar, 0), "%s: laminar", isa);
    ck_assert_msg(near_vec(f->smagorinsky[i], 1, &e->smagorinsky, 0), "%s: smagorinsky", isa);
    const float added[3] = {f->tense[i][0] - f->xsph[i][0], f->tense[i][1] - f->xsph[i][1],
                            f->tense[i][2] - f->xsph[i][2]};
    const double rounding = TOLERANCE * XSPH * e->xsph.scale;
    ck_assert_msg(near_vec(added, COHESION, &e->cohesion, rounding), "%s: cohesion", isa);
    ck_assert_msg(near_vec(f->artificial[i], ARTIFICIAL, &e->artificial, 0), "%s: artificial", isa);
    for (int rule = 0; rule < 2; rule++) {
      const scaled error = expected_error(s, e, &rules[rule], i);
      const double factor = rules[rule].relaxation * f->alpha[i];
      ck_assert_msg(fabs(f->kappa[rule][i] - factor * error.value) <=
                        factor * (error.scale + 1e-6 * fabs(error.value)),
                    "%s: kappa %g, expected %g", isa, f->kappa[rule][i], factor * error.value);
      sums[rule] += fabs(error.value);
      slacks[rule] += error.scale + 1e-6 * fabs(error.value) + 0x1p-30; /* each is rounded */
      largest[rule] = fmax(largest[rule], fabs(error.value));
    }
    float change[3];
    for (int axis = 0; axis < 3; axis++) {
      change[axis] = (float)(f->velocity[i][axis] - velocity_of(s->fluid.id[i], axis));
      ck_assert(f->moved[i][axis] == (float)f->velocity[i][axis]);
    }
    ck_assert_msg(near_vec(change, PRESSURE, &e->pressure, 1e-15), "%s: pressure", isa);
    const uint64_t id = s->fluid.id[i];
    ck_assert(f->multiplier[i] == 0.25f * kappa_of(id + 1) + kappa_of(id));
  }
  for (int rule = 0; rule < 2; rule++) {
    ck_assert_msg(fabs(hc_sum_value(&f->total[rule]) - sums[rule]) <= slacks[rule], "%s: sum %g, expected %g",
                  isa, hc_sum_value(&f->total[rule]), sums[rule]);
    ck_assert(fabs(f->max[rule] - largest[rule]) <= 1e-4 * largest[rule]);
    ck_assert(largest[rule] > 0);
  }
}

static expected *expect_all(const setting *s) {
  double *all = hc_alloc((size_t)s->fluid.own, sizeof *all);
  for (int32_t i = 0; i < s->fluid.own; i++) all[i] = relative_density(s, i);
  densities = all;
  expected *e = hc_alloc((size_t)s->fluid.own, sizeof *e);
  for (int32_t i = 0; i < s->fluid.own; i++) e[i] = expect(s, i);
  hc_free(all);
  return e;
}

START_TEST(sweeps_agree_with_plain_sums) {
  static const int32_t counts[][2] = {{517, 150}, {517, 150}, {64, 0}, {7, 30}, {1, 0}};
  found *f = hc_alloc(1, sizeof *f);
  for (int c = 0; c < 5; c++) {
    setting s;
    make_cloud(&s, counts[c][0], counts[c][1]);
    s.sweep.walls_move = c == 1;
    expected *e = expect_all(&s);
    for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
      const int32_t cuts[2] = {0, s.fluid.own};
      run_all(&s, (hc_isa)isa, cuts, 1, f);
      if (c < 2)
        check_found(&s, f, e, hc_isa_name((hc_isa)isa));
      else
        for (int32_t i = 0; i < s.fluid.own; i++)
          ck_assert(fabs(f->density[i] / REST_DENSITY - e[i].relative_density) <=
                    TOLERANCE * e[i].relative_density);
    }
    hc_free(e);
    setting_free(&s);
  }
  hc_free(f);
}
END_TEST

START_TEST(ranges_make_no_difference) {
  setting s;
  make_cloud(&s, 517, 150);
  found *whole = hc_alloc(1, sizeof *whole), *parts = hc_alloc(1, sizeof *parts);
  static const int32_t cuts[][8] = {
      {0, 517}, {0, 1, 2, 64, 65, 130, 516, 517}, {0, 0, 333, 333, 340, 348, 517, 517}};
  for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
    run_all(&s, (hc_isa)isa, cuts[0], 1, whole);
    for (int c = 1; c < 3; c++) {
      run_all(&s, (hc_isa)isa, cuts[c], 7, parts);
      ck_assert_msg(memcmp(whole, parts, sizeof *whole) == 0, "%s", hc_isa_name((hc_isa)isa));
    }
  }
  hc_free(whole);
  hc_free(parts);
  setting_free(&s);
}
END_TEST

START_TEST(vector_lengths_give_the_same_bits) {
  if (hc_isa_best() < HC_ISA_AVX512) return;
  found *eight = hc_alloc(1, sizeof *eight), *sixteen = hc_alloc(1, sizeof *sixteen);
  static const int32_t counts[][2] = {{517, 150}, {650, 0}, {77, 400}, {3, 9}};
  for (int c = 0; c < 4; c++) {
    setting s;
    make_cloud(&s, counts[c][0], counts[c][1]);
    const int32_t cuts[2] = {0, s.fluid.own};
    run_all(&s, HC_ISA_AVX2, cuts, 1, eight);
    run_all(&s, HC_ISA_AVX512, cuts, 1, sixteen);
    ck_assert(memcmp(eight, sixteen, sizeof *eight) == 0);
    float *volumes = hc_alloc_zero((size_t)s.boundary.own, sizeof *volumes);
    hc_sweeps_of(HC_ISA_AVX2)->boundary_volume(&s.sweep, &s.boundary, &s.boundary_list, 0.7f);
    memcpy(volumes, s.boundary.volume, (size_t)s.boundary.own * sizeof *volumes);
    hc_sweeps_of(HC_ISA_AVX512)->boundary_volume(&s.sweep, &s.boundary, &s.boundary_list, 0.7f);
    ck_assert(memcmp(volumes, s.boundary.volume, (size_t)s.boundary.own * sizeof *volumes) == 0);
    hc_free(volumes);
    setting_free(&s);
  }
  hc_free(eight);
  hc_free(sixteen);
}
END_TEST

/* Without walls what one particle gains another loses. */
START_TEST(pair_forces_conserve_momentum) {
  setting s;
  make_cloud(&s, 600, 0);
  found *f = hc_alloc(1, sizeof *f);
  const int32_t cuts[2] = {0, 600};
  for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
    run_all(&s, (hc_isa)isa, cuts, 1, f);
    double change[5][3] = {{0}}, magnitude[5] = {0};
    for (int32_t i = 0; i < 600; i++)
      for (int axis = 0; axis < 3; axis++) {
        const double all[5] = {f->velocity[i][axis] - velocity_of(s.fluid.id[i], axis), f->xsph[i][axis],
                               f->laminar[i][axis], f->artificial[i][axis], f->smagorinsky[i][axis]};
        for (int k = 0; k < 5; k++) {
          change[k][axis] += all[k];
          magnitude[k] += fabs(all[k]);
        }
      }
    for (int k = 0; k < 5; k++) {
      ck_assert_double_gt(magnitude[k], 0);
      for (int axis = 0; axis < 3; axis++)
        ck_assert_msg(fabs(change[k][axis]) < 1e-6 * magnitude[k], "%s, force %d: %g of %g",
                      hc_isa_name((hc_isa)isa), k, change[k][axis], magnitude[k]);
    }
  }
  hc_free(f);
  setting_free(&s);
}
END_TEST

/* A lattice two spacings to the support, shaken, each particle going against its nearest neighbours: what a
 * step of eddies that is too strong turns round. */
static void make_shaken_lattice(setting *s) {
  enum { EDGE = 9 };
  setting_init(s, 1.0);
  hc_particles_resize(&s->fluid, EDGE * EDGE * EDGE);
  for (int k = 0; k < EDGE * EDGE * EDGE; k++) {
    const int at[3] = {k % EDGE, k / EDGE % EDGE, k / EDGE / EDGE};
    for (int axis = 0; axis < 3; axis++)
      s->fluid.position[3 * k + axis] =
          (int64_t)((at[axis] + 0.2 * random_number((uint64_t)(3 * k + axis))) * (double)HC_CELL_UNITS / 2);
  }
  settle(s);
  for (int32_t i = 0; i < s->fluid.own; i++) {
    const int k = (int)s->fluid.id[i], parity = k % EDGE + k / EDGE % EDGE + k / EDGE / EDGE;
    for (int axis = 0; axis < 3; axis++)
      s->fluid.motion[i].v[axis] = (parity % 2 ? -1.0f : 1.0f) * (float)(axis + 1);
  }
}

START_TEST(eddies_take_no_energy_back) {
  static const double viscosity[] = {0, 1e-6, 0.01}, length[] = {0.003, 0.04}, dt[] = {1e-6, 1e-3, 1e3};
  setting s;
  make_shaken_lattice(&s);
  float(*change)[3] = hc_alloc((size_t)s.fluid.own, sizeof *change);
  for (int c = 0; c < 3 * 2 * 3; c++) {
    const int step = c / 6;
    if (viscosity[c % 3] * dt[step] > H * H / 32) continue; /* longer than what the step control takes */
    const hc_eddies eddies = hc_eddies_of(viscosity[c % 3], length[c / 3 % 2], H, dt[step]);
    for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
      double before = 0, after = 0;
      hc_sweeps_of((hc_isa)isa)->smagorinsky(&s.sweep, &eddies, change[0], hc_select_all(&s.fluid));
      for (int32_t i = 0; i < s.fluid.own; i++)
        for (int axis = 0; axis < 3; axis++) {
          const double v = (double)s.fluid.motion[i].v[axis];
          before += v * v;
          after += (v + (double)change[i][axis]) * (v + (double)change[i][axis]);
        }
      ck_assert_msg(after < before, "%s: %g s, length %g: energy %g from %g", hc_isa_name((hc_isa)isa),
                    dt[step], length[c / 3 % 2], after, before);
    }
  }
  hc_free(change);
  setting_free(&s);
}
END_TEST

START_TEST(eddies_of_a_step) {
  const hc_eddies usual = hc_eddies_of(1e-3, 0.003, 0.04, 0.002);
  ck_assert_double_eq_tol(usual.molecular, 1e-3 * 0.002 / 0.0016, 1e-9);
  ck_assert_double_eq_tol(usual.scale, 0.003 * 0.003 * 0.002 / (0.04 * 0.04 * 0.04), 1e-9);
  ck_assert_double_eq_tol(usual.most, 0.04 - usual.molecular, 1e-8);
  ck_assert(hc_eddies_of(1, 0.003, 0.04, 0.002).most == 0.0f); /* a step that is too long anyway */
  /* the same at any scale of lengths and times */
  const double lengths[] = {1e-9, 1e9}, times[] = {1e-12, 1e6};
  for (int k = 0; k < 2; k++) {
    const double l = lengths[k], t = times[k];
    const hc_eddies other = hc_eddies_of(1e-3 * l * l / t, 0.003 * l, 0.04 * l, 0.002 * t);
    ck_assert_double_eq_tol(other.molecular / usual.molecular, 1, 1e-6);
    ck_assert_double_eq_tol(other.scale * (l / t) / usual.scale, 1, 1e-6); /* times a speed */
    ck_assert_double_eq_tol(other.most / usual.most, 1, 1e-6);
  }
}
END_TEST

/* The density sweep leaves the rate behind; the rest of an error sweep then finds what the whole one does. */
START_TEST(errors_follow_from_rates_to_the_bit) {
  setting s;
  make_cloud(&s, 400, 100);
  const int32_t all = s.fluid.own;
  float *kappa = hc_alloc((size_t)all, sizeof *kappa);
  for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
    const hc_sweeps *sweeps = hc_sweeps_of((hc_isa)isa);
    for (int rule = 0; rule < 2; rule++) {
      set_values(&s);
      hc_error_total whole;
      memset(&whole, 0, sizeof whole);
      sweeps->density(&s.sweep, hc_select_range(0, all));
      sweeps->error_from_rate(&s.sweep, &rules[rule], hc_select_range(0, 77));
      sweeps->error_from_rate(&s.sweep, &rules[rule], hc_select_range(77, all));
      for (int32_t i = 0; i < all; i++) kappa[i] = s.fluid.place[i].scalar;
      sweeps->error(&s.sweep, &rules[rule], hc_select_range(0, all), &whole);
      bool good = true;
      for (int32_t i = 0; i < all; i++) good &= kappa[i] == s.fluid.place[i].scalar;
      ck_assert_msg(good && whole.max > 0, "%s", hc_isa_name((hc_isa)isa));
    }
  }
  hc_free(kappa);
  setting_free(&s);
}
END_TEST

/* Errors and xsph in one sweep are what two find. */
START_TEST(xsph_along_with_errors) {
  setting s;
  make_cloud(&s, 400, 100);
  const int32_t all = s.fluid.own;
  float *kappa = hc_alloc((size_t)all, sizeof *kappa), *change[2];
  for (int k = 0; k < 2; k++) change[k] = hc_alloc_zero(3 * (size_t)all, sizeof **change);
  for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
    const hc_sweeps *sweeps = hc_sweeps_of((hc_isa)isa);
    const hc_smoothing smoothing = {XSPH, change[1]};
    for (int rule = 0; rule < 2; rule++) {
      hc_error_total total[2];
      memset(total, 0, sizeof total);
      set_values(&s);
      sweeps->density(&s.sweep, hc_select_range(0, all));
      sweeps->error(&s.sweep, &rules[rule], hc_select_range(0, all), &total[0]);
      for (int32_t i = 0; i < all; i++) kappa[i] = s.fluid.place[i].scalar;
      sweeps->xsph(&s.sweep, XSPH, change[0], hc_select_range(0, all));
      sweeps->error_and_xsph(&s.sweep, &rules[rule], hc_select_range(0, 77), &total[1], &smoothing);
      sweeps->error_and_xsph(&s.sweep, &rules[rule], hc_select_range(77, all), &total[1], &smoothing);
      ck_assert(memcmp(change[0], change[1], 3 * (size_t)all * sizeof **change) == 0);
      ck_assert(total[0].sum == total[1].sum && total[0].max == total[1].max && total[0].max > 0);
      for (int32_t i = 0; i < all; i++) ck_assert(kappa[i] == s.fluid.place[i].scalar);
    }
  }
  hc_free(kappa);
  for (int k = 0; k < 2; k++) hc_free(change[k]);
  setting_free(&s);
}
END_TEST

/* Totals beyond 64 bits, and what is too large for them. */
START_TEST(error_totals_become_exact_sums) {
  hc_error_total total = {.sum = ((__int128)3 << 70) + ((__int128)5 << 31) + 1, .max = 1};
  hc_sum sum = hc_error_sum(&total);
  hc_sum_add(&sum, -0x3p40);
  ck_assert(hc_sum_value(&sum) == 10 + 0x1p-30);
  total.not_finite = true;
  sum = hc_error_sum(&total);
  ck_assert(isnan(hc_sum_value(&sum)));
}
END_TEST

START_TEST(a_bad_velocity_shows_in_the_total) {
  setting s;
  make_cloud(&s, 300, 20);
  const int32_t all = s.fluid.own;
  for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
    const hc_sweeps *sweeps = hc_sweeps_of((hc_isa)isa);
    for (int rule = 0; rule < 2; rule++) {
      set_values(&s);
      sweeps->density(&s.sweep, hc_select_range(0, all));
      s.fluid.motion[150].v[1] = NAN;
      hc_error_total total;
      memset(&total, 0, sizeof total);
      sweeps->error(&s.sweep, &rules[rule], hc_select_range(0, all), &total);
      const hc_sum sum = hc_error_sum(&total);
      ck_assert(total.not_finite && isnan(hc_sum_value(&sum)));
    }
  }
  setting_free(&s);
}
END_TEST

/* ---- the kernel ---- */

enum { STEPS = 420, PER_RADIUS = 400 };

/* One fluid and one boundary particle at each of q = 0, 1/400, ... 1.05; pairs far apart, in all directions.
 */
static void make_pairs(setting *s, vec *way) {
  setting_init(s, 1.0);
  hc_particles_resize(&s->fluid, STEPS + 1);
  hc_particles_resize(&s->boundary, STEPS + 1);
  for (int k = 0; k <= STEPS; k++) {
    for (int axis = 0; axis < 3; axis++) way[k].x[axis] = random_number((uint64_t)(3 * k + axis));
    const double length = norm(way[k]);
    for (int axis = 0; axis < 3; axis++) {
      way[k].x[axis] /= length;
      const int64_t here = (axis == 2 ? 4 * (int64_t)k * HC_CELL_UNITS : 0) + 12345 * k;
      const double away = way[k].x[axis] * k / PER_RADIUS * (double)HC_CELL_UNITS;
      s->fluid.position[3 * k + axis] = here;
      s->boundary.position[3 * k + axis] = here - (int64_t)llrint(away); /* x_i - x_b = + q way */
    }
  }
  settle(s);
  for (int k = 0; k <= STEPS; k++) s->boundary.place[k].scalar = (float)(PI * H * H * H / 8);
  s->sweep.volume = (float)(PI * H * H * H / 8);
}

START_TEST(kernel_is_the_cubic_spline) {
  setting s;
  static vec way[STEPS + 1];
  make_pairs(&s, way);
  for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
    hc_sweeps_of((hc_isa)isa)->density(&s.sweep, hc_select_range(0, s.fluid.own));
    double w[STEPS + 1], g[STEPS + 1];
    for (int i = 0; i <= STEPS; i++) {
      const int k = (int)s.fluid.id[i];
      const double q = (double)k / PER_RADIUS;
      w[k] = s.fluid.density[i] / REST_DENSITY - 1.0; /* without the particle's own share */
      const float *b = &s.fluid.wall_gradient[3 * i];
      g[k] = H * (b[0] * way[k].x[0] + b[1] * way[k].x[1] + b[2] * way[k].x[2]);
      for (int axis = 0; axis < 3; axis++) /* along the line between the two */
        ck_assert_double_eq_tol(H * b[axis], g[k] * way[k].x[axis], 3e-6);
      const double outer = fmax(1 - q, 0), inner = fmax(0.5 - q, 0);
      ck_assert_double_eq_tol(w[k], 2 * pow(outer, 3) - 8 * pow(inner, 3), 1e-6);
      ck_assert_double_eq_tol(g[k], -6 * outer * outer + 24 * inner * inner, 1e-5);
      if (q > 1) ck_assert(w[k] == 0 && g[k] == 0);
    }
    ck_assert_double_eq_tol(w[0], 1, 1e-6);
    ck_assert_double_eq_tol(w[PER_RADIUS / 2], 0.25, 1e-6);
    ck_assert_double_eq_tol(w[PER_RADIUS], 0, 1e-6);
    for (int k = 1; k < STEPS; k++) {
      const double difference = (w[k + 1] - w[k - 1]) * PER_RADIUS / 2;
      ck_assert_msg(fabs(difference - g[k]) <= 3e-4, "gradient %g at q = %g, difference %g", g[k],
                    (double)k / PER_RADIUS, difference);
      ck_assert(fabs(w[k + 1] - w[k]) <= 2.01 / PER_RADIUS && w[k + 1] <= w[k] + 2e-7); /* no jump, no rise */
      ck_assert(fabs(g[k + 1] - g[k]) <= 12.1 / PER_RADIUS);
    }
  }
  setting_free(&s);
}
END_TEST

/* A fine lattice of volumes around a particle anywhere in it: the kernel's integral, its gradient's integral.
 */
START_TEST(kernel_integrates_to_one) {
  enum { EDGE = 19 };
  setting s;
  setting_init(&s, 1.0);
  const int64_t spacing = HC_CELL_UNITS / 8;
  hc_particles_resize(&s.boundary, EDGE * EDGE * EDGE);
  for (int k = 0; k < EDGE * EDGE * EDGE; k++) {
    const int place[3] = {k % EDGE, k / EDGE % EDGE, k / EDGE / EDGE};
    for (int axis = 0; axis < 3; axis++)
      s.boundary.position[3 * k + axis] = (place[axis] - EDGE / 2) * spacing;
  }
  hc_particles_resize(&s.fluid, 1);
  for (int try = 0; try < 4; try++) {
    for (int axis = 0; axis < 3; axis++)
      s.fluid.position[axis] =
          try == 0 ? 0 : (int64_t)(random_number((uint64_t)(3 * try + axis)) * (double)spacing);
    settle(&s);
    const double volume = H * H * H / 512;
    for (int32_t k = 0; k < s.boundary.own; k++) s.boundary.place[k].scalar = (float)volume;
    for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
      hc_sweeps_of((hc_isa)isa)->density(&s.sweep, hc_select_range(0, 1));
      const double integral = s.fluid.density[0] / REST_DENSITY - VOLUME * kernel(0);
      ck_assert_msg(fabs(integral - 1) < 2e-5, "integral %.9g", integral);
      for (int axis = 0; axis < 3; axis++) ck_assert(fabs(H * s.fluid.wall_gradient[axis]) < 2e-4);
    }
  }
  setting_free(&s);
}
END_TEST

START_TEST(a_particle_alone_has_its_own_density) {
  setting s;
  setting_init(&s, 1.0);
  hc_particles_resize(&s.fluid, 1);
  settle(&s);
  set_values(&s);
  for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
    const hc_sweeps *sweeps = hc_sweeps_of((hc_isa)isa);
    sweeps->density(&s.sweep, hc_select_range(0, 1));
    ck_assert_double_eq_tol(s.fluid.density[0], REST_DENSITY * VOLUME * kernel(0), 1e-3);
    ck_assert(s.fluid.alpha[0] == 0);
    for (int axis = 0; axis < 3; axis++) ck_assert(s.fluid.wall_gradient[axis] == 0);
    hc_error_total total;
    memset(&total, 0, sizeof total);
    sweeps->error(&s.sweep, &(hc_error_rule){.of_rate = 1, .signed_error = true, .relaxation = 1},
                  hc_select_range(0, 1), &total);
    ck_assert(total.sum == 0 && !total.not_finite && total.max == 0 && s.fluid.place[0].scalar == 0);
    float change[3] = {1, 1, 1};
    sweeps->laminar(&s.sweep, 1, change, hc_select_range(0, 1));
    ck_assert(change[0] == 0 && change[1] == 0 && change[2] == 0);
    change[0] = 1;
    sweeps->smagorinsky(&s.sweep, &EDDIES, change, hc_select_range(0, 1));
    ck_assert(change[0] == 0 && change[1] == 0 && change[2] == 0);
  }
  setting_free(&s);
}
END_TEST

/* ---- boundary ---- */

START_TEST(boundary_volumes_of_a_plane) {
  enum { EDGE = 21 };
  setting s;
  setting_init(&s, 1.0);
  const double dx = H / 2, factor = 0.7;
  hc_particles_resize(&s.boundary, EDGE * EDGE);
  for (int k = 0; k < EDGE * EDGE; k++) {
    s.boundary.position[3 * k] = (k % EDGE) * HC_CELL_UNITS / 2;
    s.boundary.position[3 * k + 1] = (k / EDGE) * HC_CELL_UNITS / 2;
    s.boundary.position[3 * k + 2] = -HC_CELL_UNITS / 4;
  }
  settle(&s);
  /* Around a point of a square lattice: 4 at dx and 4 at dx sqrt 2, the next are on the edge of the support.
   */
  const double inside = factor / (kernel(0) + 4 * kernel(dx) + 4 * kernel(dx * sqrt(2.0)));
  const double corner = factor / (kernel(0) + 2 * kernel(dx) + kernel(dx * sqrt(2.0)));
  for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
    hc_sweeps_of((hc_isa)isa)->boundary_volume(&s.sweep, &s.boundary, &s.boundary_list, (float)factor);
    int interior = 0, corners = 0;
    for (int k = 0; k < EDGE * EDGE; k++) {
      const int x = (int)s.boundary.id[k] % EDGE, y = (int)s.boundary.id[k] / EDGE;
      const bool edge_x = x == 0 || x == EDGE - 1, edge_y = y == 0 || y == EDGE - 1;
      const double volume = s.boundary.volume[k];
      ck_assert(s.boundary.place[k].scalar == s.boundary.volume[k]);
      if (!edge_x && !edge_y) interior += fabs(volume / inside - 1) < TOLERANCE;
      if (edge_x && edge_y) corners += fabs(volume / corner - 1) < TOLERANCE;
    }
    ck_assert_int_eq(interior, (EDGE - 2) * (EDGE - 2));
    ck_assert_int_eq(corners, 4);
  }
  setting_free(&s);
}
END_TEST

START_TEST(boundary_volumes_agree_with_plain_sums) {
  setting s;
  make_cloud(&s, 100, 300);
  for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
    hc_sweeps_of((hc_isa)isa)->boundary_volume(&s.sweep, &s.boundary, &s.boundary_list, 0.9f);
    for (int32_t i = 0; i < s.boundary.own; i++) {
      double sum = 0;
      for (int32_t j = 0; j < s.boundary.own; j++)
        sum += kernel(norm(separation(&s, &s.boundary, i, &s.boundary, j)));
      ck_assert(fabs(s.boundary.volume[i] * sum / 0.9 - 1) <= TOLERANCE);
    }
  }
  setting_free(&s);
}
END_TEST

/* Normals, weights of edges, and thin walls here and there. */
static void face_walls(setting *s) {
  for (int32_t b = 0; b < s->boundary.own; b++) {
    const uint64_t id = s->boundary.id[b];
    const double n[3] = {random_number(31 * id), random_number(31 * id + 1), 1.5};
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int axis = 0; axis < 3; axis++) s->boundary.facing[b].v[axis] = (float)(n[axis] / length);
    s->boundary.facing[b].scalar = id % 5 == 0 ? 0.0f : id % 3 == 0 ? 1.19f : 1.0f;
  }
}

/* What squared walls add to the density of particle i, shifted by `shift`, the walls having moved for `time`.
 */
static double squared_density(const setting *s, int32_t i, const double shift[3], double time) {
  double normal[3] = {0, 0, 0}, thin = 0;
  for (int32_t b = 0; b < s->boundary.own; b++) {
    const uint64_t id = s->boundary.id[b];
    vec x = separation(s, &s->fluid, i, &s->boundary, b);
    for (int axis = 0; axis < 3; axis++) x.x[axis] += shift[axis] - time * wall_velocity_of(id, axis);
    const double share = boundary_volume_of(id) * kernel(norm(x));
    const hc_record *const facing = &s->boundary.facing[b];
    if (facing->scalar == 0.0f) thin += share;
    for (int axis = 0; axis < 3; axis++)
      normal[axis] += (double)facing->scalar * share * (double)facing->v[axis];
  }
  return (normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]) /
             (double)s->sweep.flat_wall +
         thin;
}

START_TEST(squared_walls_have_the_gradient_of_their_density) {
  setting s;
  make_cloud(&s, 500, 200);
  s.sweep.flat_wall = 0.15f;
  s.sweep.walls_move = true;
  for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
    set_values(&s);
    face_walls(&s);
    hc_sweeps_of((hc_isa)isa)->wall_sums(&s.sweep, hc_select_all(&s.fluid));
    int walled = 0;
    for (int32_t i = 0; i < s.fluid.own; i++) {
      const double none[3] = {0, 0, 0}, density = squared_density(&s, i, none, 0), step = 1e-4 * H;
      ck_assert(fabs(s.fluid.wall_density[i] - density) <= 1e-5 * (1 + density));
      for (int axis = 0; axis < 3; axis++) {
        const double up[3] = {axis == 0 ? step : 0, axis == 1 ? step : 0, axis == 2 ? step : 0},
                     down[3] = {-up[0], -up[1], -up[2]};
        const double slope = (squared_density(&s, i, up, 0) - squared_density(&s, i, down, 0)) / (2 * step);
        ck_assert(fabs(s.fluid.wall_gradient[3 * i + axis] - slope) <= 1e-4 * (1 + density) / H);
      }
      const double rate = -(squared_density(&s, i, none, 1e-6) - squared_density(&s, i, none, -1e-6)) / 2e-6;
      ck_assert(fabs(s.fluid.wall_rate[i] - rate) <= 1e-4 * (1 + density) / H);
      walled += density > 0.01;
    }
    ck_assert_int_gt(walled, 50);
  }
  setting_free(&s);
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("sweeps");
  TCase *const cases = tcase_create("pairs");
  tcase_set_timeout(cases, 60);
  tcase_add_test(cases, sweeps_agree_with_plain_sums);
  tcase_add_test(cases, squared_walls_have_the_gradient_of_their_density);
  tcase_add_test(cases, ranges_make_no_difference);
  tcase_add_test(cases, vector_lengths_give_the_same_bits);
  tcase_add_test(cases, pair_forces_conserve_momentum);
  tcase_add_test(cases, eddies_take_no_energy_back);
  tcase_add_test(cases, eddies_of_a_step);
  tcase_add_test(cases, errors_follow_from_rates_to_the_bit);
  tcase_add_test(cases, xsph_along_with_errors);
  tcase_add_test(cases, error_totals_become_exact_sums);
  tcase_add_test(cases, a_bad_velocity_shows_in_the_total);
  tcase_add_test(cases, kernel_is_the_cubic_spline);
  tcase_add_test(cases, kernel_integrates_to_one);
  tcase_add_test(cases, a_particle_alone_has_its_own_density);
  tcase_add_test(cases, boundary_volumes_of_a_plane);
  tcase_add_test(cases, boundary_volumes_agree_with_plain_sums);
  suite_add_tcase(suite, cases);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
