/* Who owns which part of the world: the map from bricks to ranks, its balance, and the moves it asks for.
 *
 * Slabs: bricks in lexicographic order along the domain's longest axis (then the other two) are cut into as
 * many intervals as there are ranks. The cuts give every brick of the unbounded world an owner, also one that
 * has never held a particle, by a rule that every rank evaluates alone. Several ranks may share a layer of
 * bricks; some may own nothing. */
#ifndef HC_DOMAIN_H
#define HC_DOMAIN_H

#include "comm/comm.h"
#include "space/cells.h"

/* The load of a particle, as the balance sees it. */
enum { HC_DOMAIN_FLUID_WEIGHT = 16, HC_DOMAIN_BOUNDARY_WEIGHT = 1 };

typedef struct hc_domain {
  hc_comm *comm;
  const hc_frame *frame;
  int axis;       /* the slabs' */
  hc_brick *cuts; /* size - 1: rank r owns from cuts[r - 1] to before cuts[r] */
} hc_domain;

/* Before the first balance rank 0 owns the world. Local. */
void hc_domain_init(hc_domain *domain, hc_comm *comm, const hc_frame *frame);
void hc_domain_free(hc_domain *domain);

/* The rank that owns a brick. Local. */
int hc_domain_owner(const hc_domain *domain, hc_brick brick);

/* Largest over mean number of own fluid particles. Collective. */
double hc_domain_imbalance(hc_domain *domain, const hc_particles *fluid);

/* Cuts anew for equal load, particles counted by their weights, from particles wherever
 * they are. Collective. The particles must migrate afterwards. Returns the imbalance (of this load) after the
 * cut. */
double hc_domain_balance(hc_domain *domain, const hc_particles *fluid, const hc_particles *boundary);

/* Sends every own particle to the owner of its brick; drops ghosts. The order of own particles is undefined
 * afterwards (sort them). Collective. Returns how many left this rank. */
int32_t hc_domain_migrate(hc_domain *domain, hc_particles *particles);

#endif
