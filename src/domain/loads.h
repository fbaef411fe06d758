/* What there is to divide: the load of each occupied ownership brick, gathered on rank 0. */
#ifndef HC_LOADS_H
#define HC_LOADS_H

#include "comm/comm.h"
#include "map.h"
#include "space/neighbors.h"

/* What the particles of a rank cost. A fluid particle costs by its neighbours, HC_COST_PARTICLE for itself
 * and one for each in the fluid, a quarter for each in walls, whose sums a step forms once, times as often as
 * it found its forces in the last step; a boundary particle, which only waits for fluid, little. */
enum { HC_COST_PARTICLE = 16, HC_COST_WALL_SHARE = 4, HC_COST_FLUID = 48, HC_COST_BOUNDARY = 3 };

typedef struct hc_work {
  const hc_particles *fluid, *boundary, *moving; /* own particles, wherever they are; moving may be null */
  const hc_neighbors *neighbors,
      *walls;   /* lists of all own fluid particles; null: each costs HC_COST_FLUID */
  double block; /* s: of which the fluid's time_step, where it has one, is a part; 0: none */
  double busy;  /* seconds that they have kept this rank busy lately; 0: nothing was measured (on any rank) */
} hc_work;

/* A rank's share of a brick. */
typedef struct hc_load {
  hc_brick brick; /* first: see hc_map_by */
  float weight;
  int32_t fluid, boundary; /* particles */
  int32_t rank;            /* that holds them */
} hc_load;

/* Edge bits for ownership bricks: the largest ones of which there are HC_BRICKS_A_RANK with fluid for every
 * rank, so that it can be balanced with; counts[b] is how many with 2^b cells along an edge. Local. */
enum { HC_BRICKS_A_RANK = 64 };
int hc_loads_choose_bits(const int64_t counts[HC_MAP_MOST_BITS + 1], int ranks);

/* The same for the fluid of all ranks; a brick that several hold counts several times. Collective. */
int hc_loads_bits(hc_comm *comm, const hc_map *map, const hc_particles *fluid);

/* The loads of all ranks' bricks on rank 0, in no order (hc_free); elsewhere none. Collective. */
hc_load *hc_loads_gather(hc_comm *comm, const hc_map *map, int bits, const hc_work *work, int64_t *count);

#endif
