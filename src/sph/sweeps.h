/* The pair sweeps: loops over own particles and their neighbours. They know no ranks and no solver, only
 * arrays.
 *
 * Kernel: cubic spline (Monaghan 1992) with support radius h, q = r/h,
 *   W = 8/(pi h^3) * (2 (1 - q)^3 - 8 (1/2 - q)^3), each bracket clamped at 0 from below.
 * Inside the loops lengths are in support radii; densities and errors are fractions of the rest density, so
 * masses enter as volumes: V = m/rho0 for fluid, V_b for boundary particles. Pair arithmetic is single
 * precision, eight neighbours at a time, summed in a fixed tree; velocities are updated in double precision.
 *
 * Each sweep covers a selection of own particles, that of the lists or a part of it: all, the border, the
 * interior, those that are due. What it leaves with a particle does not depend on who else is in it. */
#ifndef HC_SWEEPS_H
#define HC_SWEEPS_H

#include "base/exact_sum.h"
#include "base/isa.h"
#include "space/neighbors.h"
#include "space/selection.h"
#include "tait.h"

/* What walls add to the densities and pressures of predicted positions. */
typedef enum hc_wall_rule {
  HC_WALLS_NOTHING,
  HC_WALLS_MIRRORED, /* volumes V_b; the fluid particle's pressure (Akinci et al. 2012) */
  HC_WALLS_PRESSURE, /* the volume and mass of fluid; a pressure of their own (Ihmsen et al. 2010) */
  HC_WALLS_DISTANCE  /* a density that depends on the distance; no pressure (Harada et al. 2007) */
} hc_wall_rule;

/* What a wall's samples took out of a particle's velocity one by one, m/s: a list of those it happened to, by
 * ascending particle. */
typedef struct hc_hold {
  int32_t particle;
  float change[3];
} hc_hold;

typedef struct hc_holds {
  hc_hold *at;
  size_t count, room;
} hc_holds;

/* What holds the fluid back that goes along a wall, see solver/wall_layer.h. */
typedef enum hc_friction_law {
  HC_FRICTION_NONE,
  HC_FRICTION_NO_SLIP,
  HC_FRICTION_SMOOTH,
  HC_FRICTION_ROUGH
} hc_friction_law;

typedef struct hc_wall_friction {
  _Alignas(16) hc_friction_law law;
  double roughness; /* m: k_s of a rough wall */
} hc_wall_friction;

/* What walls did to a particle next to them: its change of velocity by friction, m/s, and the body force,
 * m/s2, by which pressure gained behind the wetted surface. A list by ascending particle. */
typedef struct hc_touch {
  int32_t particle;
  float rub[3], depth[3];
} hc_touch;

typedef struct hc_touches {
  hc_touch *at;
  size_t count, room;
} hc_touches;

/* Sums over the samples around a particle. But for depth they are over those of walls with friction in front
 * of which it is, with W without its constant as weight. */
typedef struct hc_wall_around {
  float weight, height;         /* W, W times the height over the sample's plane in support radii */
  float normal[3], velocity[3]; /* W n_b, W v_b; velocity 0 where no wall moves */
  float area[3];                /* grad W */
  float depth[3];               /* V_b (depth.(x_b - x_i)) grad W over all, m/s2, by hc_touch.depth */
} hc_wall_around;

/* Keeps divisions by r^2 finite: 0.01 smoothing lengths squared (half a support radius each). */
#define HC_GUARD 0.0025f

/* How a viscosity acts between fluid and walls. */
typedef enum hc_drag_kind { HC_DRAG_NONE, HC_DRAG_ARTIFICIAL, HC_DRAG_LAMINAR } hc_drag_kind;
typedef struct hc_wall_drag {
  hc_drag_kind kind;
  double coefficient; /* m2/s: alpha h c of artificial, nu of laminar */
} hc_wall_drag;

/* What all sweeps of a step read. */
typedef struct hc_sweep {
  float scale[3];     /* 1 / support radius of one unit along each axis */
  float support;      /* m */
  float volume;       /* V, m3 */
  float kernel;       /* 8/(pi h^3), 1/m3 */
  float gradient;     /* 8/(pi h^4), 1/m4 */
  float rest_density; /* kg/m3 */
  float wall_offset;  /* of boundary samples behind the wetted surface, in support radii */
  float reach;        /* m: nearer to a sample a particle is in contact, where walls are rigid */
  bool compressible;  /* pressures push by p/D^2, not by p */
  hc_wall_rule walls_add;
  float flat_wall; /* MIRRORED: the density share of a flat wall a spacing away, where it goes with the
                      square; 0: where it is the sum */
  hc_particles *fluid;
  hc_particles *boundary;           /* walls that stand still; behind their records those of moving ones.
                                       place.scalar is V_b, or what the boundary method makes of it; motion the velocity
                                       and the wall's number */
  const hc_neighbors *list;         /* fluid -> fluid */
  const hc_neighbors *walls;        /* fluid -> boundary, all of it */
  bool walls_move;                  /* has any boundary particle a velocity? */
  bool no_slip;                     /* do walls hold the fluid in laminar sweeps? */
  hc_wall_drag drag;                /* for what walls feel of it */
  const hc_wall_friction *friction; /* of each wall, by its number; null: no wall has any */
  bool friction_differs;            /* from wall to wall */
  const hc_touches *touches;        /* of the last step; may be null */
  hc_holds *holds;                  /* of the last step, where walls hold so (MIRRORED); may be null */
  const hc_record *contacts; /* v: change of velocity by contact in the last step, m/s; null where walls are
                                not  rigid */
} hc_sweep;

/* How the error sweep weighs: e_i = of_density (D_i - 1) + of_rate dD_i/dt + of_gap min(0, D_i - 1). */
typedef struct hc_error_rule {
  float of_density, of_rate, of_gap;
  int min_neighbors; /* fluid and boundary; with fewer the error counts as 0 */
  bool signed_error; /* keep negative errors too */
  float relaxation;  /* of the multiplier: alpha e is a diagonal step, which overshoots where it may go both
                        ways */
} hc_error_rule;

/* What an error sweep adds up: |e_i| in units of 2^-30, rounded each by itself, so that the sum does not
 * depend on the order; and the largest. */
typedef struct hc_error_total {
  __int128 sum;
  float max;
  bool not_finite; /* an error was no number or beyond 2^30 */
} hc_error_total;

/* XSPH found along with errors: change (three of each own particle) as the sweep xsph finds it. */
typedef struct hc_smoothing {
  float weight, *change;
} hc_smoothing;

/* Multipliers on trial, while conjugate directions look for those that leave no compression
 * (solver/conjugate.h). Velocities have come about with y; K is what the search has settled on, e_b the error
 * it expects there. Own particles in order. */
typedef struct hc_trial {
  float dt;               /* s: e = D - 1 + dt dD/dt */
  float *multiplier;      /* y, m2 */
  float *base, *expected; /* K, m2; e_b */
  float least;            /* of multipliers: 0; with negative pressures all may be */
  double unit;            /* of the products' sums, m2 */
  float relaxation;       /* of alpha */
} hc_trial;

/* Products over own particles, in the trial's units, rounded each by itself, so that sums do not depend on
 * the order; s = y - K, e at y; those with alpha over particles with y > least or e > 0. */
typedef struct hc_trial_sums {
  uint64_t step_expected, step_found;                      /* s e_b; s (e_b - e) */
  uint64_t expected_expected, expected_found, found_found; /* alpha e_b e_b, alpha e_b e, alpha e e */
} hc_trial_sums;

/* Where the next trial is: K += reach s, e_b += reach (e - e_b), then y = K + length (alpha e_b + turn s). */
typedef struct hc_turn {
  float reach, length, turn;
} hc_turn;

enum { HC_WALL_WEIGHTS = 64 }; /* steps of the table of weights */

/* What the sweeps over predicted positions (PCISPH) read. */
typedef struct hc_prediction {
  bool shepard;         /* densities are divided by sum V_j W; then predicted_density leaves the pressure */
  bool negative;        /* pressures may fall below 0 */
  float stiffness;      /* of p/rho0 to the relative density error, m2/s2: 1/(2 V^2 dt^2 sum |grad W|^2);
                           0: pressures stay */
  float leaves;         /* share of the compression that becomes late_compression; in steps 0 */
  float dt;             /* s */
  const float *weights; /* DISTANCE: density at k/HC_WALL_WEIGHTS support radii from the samples, 0 to all */
} hc_prediction;

/* What a particle's contact with walls is judged by. */
typedef enum hc_contact_rule {
  HC_CONTACT_WEIGHTED, /* samples nearer than reach: Ihmsen et al. 2010, eq. 9 to 11 */
  HC_CONTACT_DISTANCE  /* the distance from the plane through the samples near it */
} hc_contact_rule;

/* The viscosity of pairs with eddies, by hc_eddies_of; nu dt over the square of the support radius. */
typedef struct hc_eddies {
  float molecular; /* nu of the fluid */
  float scale;     /* s/m: times the relative speed over the distance in support radii, nu of the eddies */
  float most;      /* of the eddies */
} hc_eddies;

/* Viscosity as the sweeps see it: velocity change = weight * sum, see each sweep. Walls take part where they
 * have volumes (MIRRORED). */
typedef struct hc_sweeps {
  /* What follows from positions and velocities alone: density = rho0 (V sum W + sum_b V_b W), motion.scalar =
   * 1/D, wall_density = sum_b V_b W and its gradient wall_gradient B, wall_rate = sum_b V_b v_b . grad W,
   * alpha = 1/(|V sum grad W + B|^2 + V^2 sum |grad W|^2), 0 where the denominator vanishes; and place.scalar
   * = dD/dt, as the error sweep has it. Akinci et al. 2012; Bender and Koschier 2015, eq. 9; the squared sum
   * runs over fluid neighbours only. */
  void (*density)(const hc_sweep *sweep, hc_selection selection);

  /* wall_density, wall_gradient and wall_rate alone. */
  void (*wall_sums)(const hc_sweep *sweep, hc_selection selection);

  /* dD/dt = V sum (v_i - v_j) . grad W + v_i . B - wall_rate, then by the rule the error e_i, clamped at 0
   * from below unless signed, and place.scalar = relaxation alpha_i e_i. Adds |e_i| to the total. Carensac et
   * al. 2023, eq. 2 and algorithms 3, 4. */
  void (*error)(const hc_sweep *sweep, const hc_error_rule *rule, hc_selection selection,
                hc_error_total *total);

  /* The end of it alone, where place.scalar already is dD/dt; nothing is added up. */
  void (*error_from_rate)(const hc_sweep *sweep, const hc_error_rule *rule, hc_selection selection);

  /* The same as error, and the change by xsph (below) of these velocities with it. */
  void (*error_and_xsph)(const hc_sweep *sweep, const hc_error_rule *rule, hc_selection selection,
                         hc_error_total *total, const hc_smoothing *smoothing);

  /* The same as error for multipliers on trial: place.scalar = e_i = D_i - 1 + dt dD/dt, with its sign; adds
   * e_i to the total where positive, or its size where multipliers may be; and products to the sums, unless
   * null. */
  void (*trial_error)(const hc_sweep *sweep, const hc_trial *trial, hc_selection selection,
                      hc_error_total *total, hc_trial_sums *sums);

  /* From place.scalar = e_i to the next trial: K and e_b are entered, and place.scalar = y - y before, which
   * pressure adds to y. */
  void (*next_trial)(const hc_sweep *sweep, const hc_trial *trial, const hc_turn *turn,
                     hc_selection selection);

  /* v_i -= weight (V sum (kappa_i + kappa_j) grad W + kappa_i B) with kappa = place.scalar; multiplier_i +=
   * kappa_i. Carensac et al. 2023, eq. 1. */
  void (*pressure)(const hc_sweep *sweep, float weight, float *multiplier, hc_selection selection);

  /* change_i = weight sum V (1/D_i + 1/D_j)/2 (v_j - v_i) W: XSPH (Schechter and Bridson 2012), symmetric in
   * i and j so that it conserves momentum. */
  void (*xsph)(const hc_sweep *sweep, float weight, float *change, hc_selection selection);

  /* change_i = weight sum V 2 (v_i - v_j) (x_ij . grad W)/(r^2 + 0.01 (h/2)^2), boundary neighbours with V_b
   * included: laminar viscosity (Morris et al. 1997) at rest density; weight = nu dt. Behind the wetted
   * surface the velocity goes on as it comes to the wall's there: v_i - v_b = (v_i - v_wall) (1 + d_b/d_i)
   * with the distances from the surface along B, at most twice. Walls of PRESSURE take part with V,
   * and the velocity goes on as far behind the surface as the layer of the sample is. */
  void (*laminar)(const hc_sweep *sweep, float weight, float *change, hc_selection selection);

  /* change_i = dt sum V 2 nu_ij (v_i - v_j) (x_ij . grad W)/(r^2 + 0.01 (h/2)^2) over fluid neighbours: that
   * of laminar with a viscosity of the pair, nu_ij = nu + min(L^2 |v_ij|/sqrt(r^2 + 0.01 (h/2)^2), the most).
   * In place of the eddy viscosity L^2 |S| of Smagorinsky 1963 with |S| = sqrt(2 S:S), which would need the
   * velocity gradient first: in a simple shear the stress is 3/4 of that, in a plane stretch 0.44. */
  void (*smagorinsky)(const hc_sweep *sweep, const hc_eddies *eddies, float *change, hc_selection selection);

  /* change_i = weight sum V min(0, v_ij . x_ij)/(r^2 + 0.01 (h/2)^2) grad W, boundary likewise: artificial
   * viscosity (Monaghan 1992) at rest density; weight = alpha h c dt. */
  void (*artificial)(const hc_sweep *sweep, float weight, float *change, hc_selection selection);

  /* change_i += -weight sum W (x_i - x_j) over fluid neighbours: surface tension (Becker and Teschner 2007);
   * weight = kappa dt. */
  void (*cohesion)(const hc_sweep *sweep, float weight, float *change, hc_selection selection);

  /* Weakly compressible fluid: density, wall_density, wall_gradient and wall_rate as of the density sweep,
   * the pressure of the density, and place.scalar = p/(rho0 D^2). Adds D - 1 where positive, or its size
   * where pressures may be negative, to the total. He et al. 2015, eq. 1 and 2. */
  void (*weak_density)(const hc_sweep *sweep, const hc_tait *tait, hc_selection selection,
                       hc_error_total *total);

  /* change_i += weight (-V sum (s_i + s_j) grad W - s_i B + the sum of artificial with viscosity = alpha h c)
   * with s = place.scalar; rate_i = dD/dt as in the error sweep, unless null. He et al. 2015, eq. 4 and 5. */
  void (*weak_forces)(const hc_sweep *sweep, float viscosity, float weight, float *change, float *rate,
                      hc_selection selection);

  /* What `count` particles next to walls have around them; all of the fluid must be listed. */
  void (*wall_layer)(const hc_sweep *sweep, const hc_touch *touches, int32_t count, hc_wall_around *around);

  /* boundary->place.scalar = volume = factor / (W(0) + sum_b W) over boundary neighbours. Akinci et al. 2012,
   * eq. 4. */
  void (*boundary_volume)(const hc_sweep *sweep, hc_particles *boundary, const hc_neighbors *list,
                          float factor);

  /* At the positions in place, D_i = V sum W + the walls' share; density = rho0 D_i; then, unless Shepard's
   * correction is still to come (motion.scalar = 1/D_i for it), the end of the prediction: the relative error
   * D_i - 1 where positive is added to the total, pressure += rho0 stiffness (D_i - 1 - late_compression),
   * clamped at 0 from below unless it may be negative, and place.scalar = pressure/(rho0 D_i^2), MIRRORED:
   * pressure/rho0. Ihmsen et al. 2010, eq. 2, 3, 13; they leave nothing for later. */
  void (*predicted_density)(const hc_sweep *sweep, const hc_prediction *prediction, hc_selection selection,
                            hc_error_total *total);

  /* D_i becomes D_i/(V sum W/D_j + walls), and the prediction ends as above. Bonet and Kulasegaram 2002.
   * Ghosts' motion.scalar must be current; walls count with their V_b. */
  void (*corrected_density)(const hc_sweep *sweep, const hc_prediction *prediction, hc_selection selection,
                            hc_error_total *total);

  /* The same of own particles of a boundary store that have a pressure: D_b = boundary_share + V sum W over
   * fluid, `wetted` being the store's neighbours there. */
  void (*boundary_density)(const hc_sweep *sweep, const hc_prediction *prediction, hc_particles *boundary,
                           const hc_neighbors *wetted, hc_selection selection);

  /* push_i = -dt (V sum (s_i + s_j) grad W + the walls' part) with s = place.scalar. Ihmsen et al. 2010,
   * eq. 6. */
  void (*push)(const hc_sweep *sweep, const hc_prediction *prediction, hc_selection selection);

  /* contacts_i: v the direction away from the walls (not of unit length; 0: no contact), scalar the depth, m.
   * WEIGHTED: w = max(0, 1 - r/reach); v = sum w n_b, depth = sum w (reach - r) / sum w. DISTANCE: over
   * samples in front of which the particle is, with w = max(0, 1 - r/h), v = sum w n_b and depth = reach -
   * sum w (x_i - x_b) . n_b / sum w, which may be negative. */
  void (*contacts)(const hc_sweep *sweep, hc_contact_rule rule, hc_record *contacts, hc_selection selection);

  /* velocities_i.v = sum w v_b / sum w with the weights of WEIGHTED: how fast the walls move that are
   * touched; 0 without contact. */
  void (*wall_velocities)(const hc_sweep *sweep, hc_record *velocities, hc_selection selection);
} hc_sweeps;

/* From boundary record b to fluid particle i, in support radii. */
static inline void hc_sweep_from_wall(const hc_sweep *sweep, int32_t i, int32_t b, double d[3]) {
  for (int axis = 0; axis < 3; axis++)
    d[axis] = (double)(int32_t)((uint32_t)sweep->fluid->place[i].x[axis] -
                                (uint32_t)sweep->boundary->place[b].x[axis]) *
              (double)sweep->scale[axis];
}

/* How high such a d is over the plane of sample b. */
static inline double hc_sweep_over_wall(const hc_sweep *sweep, int32_t b, const double d[3]) {
  const float *const n = sweep->boundary->facing[b].v;
  return d[0] * (double)n[0] + d[1] * (double)n[1] + d[2] * (double)n[2];
}

/* The sweeps compiled for an instruction set. */
const hc_sweeps *hc_sweeps_of(hc_isa isa);

const hc_sweeps *hc_sweeps_portable(void);
const hc_sweeps *hc_sweeps_avx2(void);
const hc_sweeps *hc_sweeps_avx512(void);

/* Kernel constants for a support radius and particle volume; the arrays are left null. */
hc_sweep hc_sweep_make(const hc_frame *frame, double volume, double rest_density);

/* Eddies of the mixing length L over a step, beside the fluid's own viscosity nu (m2/s). They get the most
 * with which the step surely takes no energy back: it is v_i -= sum w_ij (v_i - v_j) with w_ij = w_ji, whose
 * eigenvalues are in [-1, 1] if sum_j w_ij <= 1 (Gershgorin), and in a full support 2 sum V |x . grad W|/r^2
 * = 24/h^2 at most. So nu_ij dt <= h^2/25, whatever speeds and distances are. */
hc_eddies hc_eddies_of(double viscosity, double mixing_length, double support_radius, double dt);

#endif
