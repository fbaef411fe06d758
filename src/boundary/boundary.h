/* The boundary methods behind one table of operations, chosen by name. */
#ifndef HC_BOUNDARY_METHODS_H
#define HC_BOUNDARY_METHODS_H

#include "sph/sweeps.h"

#include <math.h>

/* The world collision of predicted positions, see hc_boundary_ops.collide. */
typedef struct hc_collision {
  const hc_sweeps *sweeps;
  const hc_sweep *sweep;
  const double *unit; /* metres per unit along each axis */
  double friction,
      elasticity;        /* share of the tangential velocity that stays; of the normal one that returns */
  double dt;             /* s */
  hc_record *contacts;   /* room for one for each own particle */
  hc_record *velocities; /* the same for those of the walls; null where none moves */
  bool respond;          /* change velocities too: the end of the step */
} hc_collision;

typedef struct hc_boundary_ops {
  const char *name;
  hc_wall_rule walls; /* in densities and pressures of predicted positions */
  unsigned features;  /* HC_FOR_*: the fields it needs */

  /* Prepares own boundary particles once they are placed: what the sweeps read of them. `list` holds their
   * boundary neighbours, ghosts included; `factor` scales the volumes, or is the largest share of the
   * boundary in its own density where samples of frozen fluid overlap. Local; the caller refreshes the
   * ghosts. */
  void (*prepare)(const hc_sweeps *sweeps, const hc_sweep *sweep, hc_particles *boundary,
                  const hc_neighbors *list, double factor);

  /* The last word before selected own fluid particles move by dt, or by dt times their own of `shares`: takes
   * away what would carry one into a wall. `limit` is the wall density of a particle on a flat wall's wetted
   * surface. The push adds to the particle's pressure, or is added to sweep->holds. Returns how many were
   * held. Local. Null where `collide` does it. */
  int64_t (*contact)(const hc_sweep *sweep, hc_selection selection, double limit, double dt,
                     const float *shares);

  /* Moves selected own particles, whose place holds predicted positions and velocity the predicted one,
   * out of the walls. motion holds the velocities at the step's beginning. Returns how many were in one.
   * Local. Null where `contact` does it. */
  int64_t (*collide)(const hc_collision *collision, hc_selection selection);
} hc_boundary_ops;

/* Single layer, volumes V_b = factor / sum W over boundary particles, pressure mirrored from the fluid
 * particle (Akinci et al. 2012; Carensac et al. 2023, A.2), with a contact for particles that pressure does
 * not stop. */
extern const hc_boundary_ops hc_boundary_akinci2012;

/* Direct forcing with weights, and boundary particles that have a density and a pressure (Ihmsen et al. 2010,
 * eq. 9 to 13). Two layers: with one, boundary densities stay below the rest density and nothing pushes. */
extern const hc_boundary_ops hc_boundary_ihmsen2010;

/* Direct forcing, sample by sample (Becker, Tessendorf, Teschner 2009; Ihmsen et al. 2010, eq. 7 and 8):
 * walls have neither density nor pressure. */
extern const hc_boundary_ops hc_boundary_becker2009;

/* A wall weight by distance, and a force that holds the distance (Harada, Koshizuka, Kawaguchi 2007). */
extern const hc_boundary_ops hc_boundary_harada2007;

/* Gives own boundary particles the volume of fluid particles and the densities that they make among
 * themselves: what the methods do whose samples are frozen fluid. As hc_boundary_ops.prepare. */
void hc_boundary_prepare_frozen(const hc_sweeps *sweeps, const hc_sweep *sweep, hc_particles *boundary,
                                const hc_neighbors *list, double factor);

/* The unit vector along a contact; false if it has none. */
static inline bool hc_collision_direction(const hc_record *contact, double n[3]) {
  for (int axis = 0; axis < 3; axis++) n[axis] = contact->v[axis];
  const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  for (int axis = 0; axis < 3; axis++) n[axis] /= length;
  return length > 0.0;
}

/* Moves the predicted position of particle i by `distance` m along the unit vector n. */
static inline void hc_collision_shift(const hc_collision *collision, int32_t i, double distance,
                                      const double n[3]) {
  hc_record *place = &collision->sweep->fluid->place[i];
  for (int axis = 0; axis < 3; axis++)
    place->x[axis] = (int32_t)((uint32_t)place->x[axis] +
                               (uint32_t)(int32_t)llrint(distance * n[axis] / collision->unit[axis]));
}

/* Changes the velocity of particle i along axis and enters that into its contact. */
static inline void hc_collision_change(const hc_collision *collision, int32_t i, int axis, double change) {
  collision->sweep->fluid->velocity[3 * (size_t)i + (size_t)axis] += change;
  collision->contacts[i].v[axis] += (float)change;
}

/* The velocity of particle i after contact along the unit vector n with a wall of velocity `wall`: eq. 12,
 * with the returning part of eq. 7. */
static inline void hc_collision_respond(const hc_collision *collision, int32_t i, const double n[3],
                                        const float wall[3]) {
  const double *v = &collision->sweep->fluid->velocity[3 * (size_t)i];
  const float *before = collision->sweep->fluid->motion[i].v;
  double relative[3], normal = 0.0, approach = 0.0;
  for (int axis = 0; axis < 3; axis++) {
    relative[axis] = v[axis] - (double)wall[axis];
    normal += relative[axis] * n[axis];
    approach += ((double)before[axis] - (double)wall[axis]) * n[axis];
  }
  const double back = approach < 0.0 ? -collision->elasticity * approach : 0.0;
  for (int axis = 0; axis < 3; axis++)
    hc_collision_change(collision, i, axis,
                        collision->friction * (relative[axis] - normal * n[axis]) + back * n[axis] -
                            relative[axis]);
}

#endif
