/* Who owns which part of the world: the map from cells to ranks, its balance, and the moves it asks for.
 *
 * Slabs: ownership bricks, row by row from the domain's longest axis, are cut into one interval a rank;
 * several ranks may share a layer of bricks. METIS: the graph of occupied bricks is divided so that a cut
 * makes few ghosts, parts are given to ranks so that few of these leave a host, and are written down as
 * intervals in Morton order. Some ranks may own nothing.
 * Which it is and where the borders lie never changes what particles do. */
#ifndef HC_DOMAIN_H
#define HC_DOMAIN_H

#include "comm/comm.h"
#include "hosts.h"
#include "loads.h"
#include "map.h"
#include "partners.h"

typedef enum hc_divider { HC_DIVIDER_SLABS, HC_DIVIDER_METIS } hc_divider;

typedef struct hc_domain {
  hc_comm *comm;
  const hc_frame *frame;
  hc_map map;
  hc_hosts hosts;
  int64_t divisions;    /* how often the world has been divided */
  hc_partners partners; /* of one store's particles */
} hc_domain;

/* How a decomposition turned out; the same on every rank. */
typedef struct hc_division {
  hc_divider divider;   /* slabs also where METIS was asked for and failed */
  char way[16];         /* METIS: "k-way", "recursive"; slabs: the axis */
  double before, after; /* largest over mean load, where particles lay and where they go */
  int64_t bricks;       /* occupied */
  int64_t moving;       /* particles that change their rank */
  int32_t bits, intervals;
} hc_division;

/* Before the first balance rank 0 owns the world. `ranks_per_host`: see hc_hosts_find. Collective. */
void hc_domain_init(hc_domain *domain, hc_comm *comm, const hc_frame *frame, int ranks_per_host);
void hc_domain_free(hc_domain *domain);

/* The rank that owns a cell. Local. */
int hc_domain_owner(const hc_domain *domain, const int64_t cell[3]);

/* Largest over mean number of own fluid particles. Collective. */
double hc_domain_imbalance(hc_domain *domain, const hc_particles *fluid);

/* Divides the world anew for equal load, from particles wherever they are. Collective. The particles must
 * migrate afterwards. `division` may be null. */
void hc_domain_balance(hc_domain *domain, hc_divider divider, const hc_work *work, hc_division *division);

/* Sends every own particle to the owner of its cell; drops ghosts. The order of own particles is undefined
 * afterwards (sort them). Collective. Returns how many left this rank. */
int32_t hc_domain_migrate(hc_domain *domain, hc_particles *particles);

/* As hc_comm_sparse, `out` ascending, for particles: among partners where they are known and agreed on.
 * Collective. */
void hc_domain_exchange(hc_domain *domain, const hc_particles *particles, const hc_message *out,
                        int out_count, hc_message **in, int *in_count);

/* The partners of a store's particles, of one store at a time:
 * - settle, when they are with their owners and have their ghosts: what was agreed is used up; learns
 * partners if they are not known. Collective: a sparse exchange if it learns.
 * - watch, when they have moved: has one left what is covered? Local.
 * - agree, on what all ranks have watched, if nothing else moves them: the next exchanges go among partners.
 *   Local.
 * - forget: nothing is agreed, as when particles come, or are moved by others than steps. Local, on all
 * ranks. */
void hc_domain_settle_partners(hc_domain *domain, const hc_particles *particles);
bool hc_domain_watch_partners(hc_domain *domain);
void hc_domain_agree_partners(hc_domain *domain, bool outside);
void hc_domain_forget_partners(hc_domain *domain);

#endif
