#include "domain.h"

#include "base/memory.h"
#include "bricks.h"
#include "fringe.h"
#include "graph.h"

#include <stdio.h>

void hc_domain_init(hc_domain *domain, hc_comm *comm, const hc_frame *frame, int ranks_per_host) {
  int64_t origin[3];
  for (int axis = 0; axis < 3; axis++) origin[axis] = hc_frame_cell(frame->origin[axis]);
  *domain = (hc_domain){.comm = comm, .frame = frame};
  hc_hosts_find(&domain->hosts, comm, ranks_per_host);
  hc_map_init(&domain->map, origin);
  hc_partners_init(&domain->partners);
}

void hc_domain_free(hc_domain *domain) {
  hc_map_free(&domain->map);
  hc_hosts_free(&domain->hosts);
  hc_partners_free(&domain->partners);
}

int hc_domain_owner(const hc_domain *domain, const int64_t cell[3]) {
  return hc_map_owner(&domain->map, hc_map_brick(&domain->map, domain->map.bits, cell));
}

double hc_domain_imbalance(hc_domain *domain, const hc_particles *fluid) {
  int64_t largest = fluid->own, total = fluid->own;
  hc_comm_max_i64(domain->comm, &largest, 1);
  hc_comm_sum_i64(domain->comm, &total, 1);
  return total > 0 ? (double)largest * domain->comm->size / (double)total : 1.0;
}

/* Divides by METIS and fills the map; false if METIS failed. Rank 0. */
static bool divide_by_metis(hc_domain *domain, int bits, hc_load *loads, int64_t count,
                            hc_division *division) {
  const int ranks = domain->comm->size;
  hc_map *map = &domain->map;
  hc_map_start(map, HC_ORDER_MORTON, bits);
  hc_bricks bricks;
  hc_bricks_init(&bricks, loads, count, map->order);
  int32_t *part = hc_alloc((size_t)bricks.count, sizeof *part);
  hc_graph graph;
  hc_graph_init(&graph, &bricks, map, domain->frame);
  const char *way = hc_graph_divide(&graph, ranks, part);
  if (way) {
    division->divider = HC_DIVIDER_METIS;
    snprintf(division->way, sizeof division->way, "%s", way);
    division->bricks = bricks.count;
    division->before = hc_bricks_imbalance_now(&bricks, ranks);
    int32_t *group = hc_alloc((size_t)ranks, sizeof *group);
    hc_graph_group(&graph, ranks, part, &domain->hosts, group);
    division->moving = hc_bricks_renumber(&bricks, ranks, &domain->hosts, group, part);
    hc_free(group);
    division->after = hc_bricks_imbalance(&bricks, ranks, part);
    hc_fringe_fill(map, &bricks, &graph, part);
  }
  hc_graph_free(&graph);
  hc_free(part);
  hc_bricks_free(&bricks);
  return way != NULL;
}

/* Cuts into slabs and fills the map. Rank 0. */
static void divide_by_slabs(hc_domain *domain, int bits, hc_load *loads, int64_t count,
                            hc_division *division) {
  const int ranks = domain->comm->size, axis = hc_bricks_longest_axis(loads, count);
  hc_map_start(&domain->map, (hc_map_order)axis, bits);
  hc_bricks bricks;
  hc_bricks_init(&bricks, loads, count, domain->map.order);
  int32_t *part = hc_alloc((size_t)bricks.count, sizeof *part);
  hc_bricks_cut(&bricks, ranks, part);
  for (int32_t k = 0; k < bricks.count; k++) part[k] = domain->hosts.order[part[k]];
  division->divider = HC_DIVIDER_SLABS;
  snprintf(division->way, sizeof division->way, "along %c", "xyz"[axis]);
  division->bricks = bricks.count;
  division->before = hc_bricks_imbalance_now(&bricks, ranks);
  division->moving = hc_bricks_moving(&bricks, part);
  division->after = hc_bricks_imbalance(&bricks, ranks, part);
  for (int32_t k = 0; k < bricks.count; k++) hc_map_add(&domain->map, bricks.brick[k].brick, part[k]);
  hc_free(part);
  hc_bricks_free(&bricks);
}

/* What rank 0 tells the others before the intervals. */
typedef struct outcome {
  hc_division division;
  hc_map_order order;
} outcome;

static void share_map(hc_domain *domain, hc_division *division) {
  hc_map *map = &domain->map;
  division->intervals = map->count;
  outcome outcome = {*division, map->order};
  hc_comm_broadcast(domain->comm, &outcome, sizeof outcome, 0);
  *division = outcome.division;
  const size_t count = (size_t)division->intervals;
  if (domain->comm->rank != 0) {
    hc_map_start(map, outcome.order, division->bits);
    hc_reserve((void **)&map->intervals, &map->capacity, count, 0, sizeof *map->intervals);
    map->count = division->intervals;
  }
  hc_comm_broadcast(domain->comm, map->intervals, count * sizeof *map->intervals, 0);
}

void hc_domain_balance(hc_domain *domain, hc_divider divider, const hc_work *work, hc_division *division) {
  hc_division own = {.bits = hc_loads_bits(domain->comm, &domain->map, work->fluid)};
  int64_t count;
  hc_load *loads = hc_loads_gather(domain->comm, &domain->map, own.bits, work, &count);
  if (domain->comm->rank == 0 &&
      (divider != HC_DIVIDER_METIS || !divide_by_metis(domain, own.bits, loads, count, &own)))
    divide_by_slabs(domain, own.bits, loads, count, &own);
  hc_free(loads);
  share_map(domain, &own);
  domain->divisions++;
  domain->partners.known = domain->partners.agreed = false;
  if (division) *division = own;
}

/* ---- partners ---- */

static hc_partners_of partners_of(const hc_domain *domain) {
  return (hc_partners_of){domain->comm, domain->frame, &domain->map};
}

void hc_domain_exchange(hc_domain *domain, const hc_particles *particles, const hc_message *out,
                        int out_count, hc_message **in, int *in_count) {
  const hc_partners *partners = &domain->partners;
  if (partners->agreed && partners->particles == particles)
    hc_comm_among(domain->comm, partners->ranks, partners->count, out, out_count, in, in_count);
  else
    hc_comm_sparse(domain->comm, out, out_count, in, in_count);
}

void hc_domain_settle_partners(hc_domain *domain, const hc_particles *particles) {
  hc_partners *partners = &domain->partners;
  partners->agreed = false;
  if (domain->comm->size == 1 || (partners->known && partners->particles == particles)) return;
  const hc_partners_of of = partners_of(domain);
  hc_partners_learn(partners, &of, particles);
}

bool hc_domain_watch_partners(hc_domain *domain) {
  const hc_partners_of of = partners_of(domain);
  return domain->partners.known && !hc_partners_cover(&domain->partners, &of);
}

void hc_domain_agree_partners(hc_domain *domain, bool outside) {
  hc_partners *partners = &domain->partners;
  if (outside) partners->known = false;
  partners->agreed = partners->known;
}

void hc_domain_forget_partners(hc_domain *domain) {
  domain->partners.agreed = false;
}
