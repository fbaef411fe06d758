/* The occupied ownership bricks of the whole world, as rank 0 divides them. Local. */
#ifndef HC_BRICKS_H
#define HC_BRICKS_H

#include "hosts.h"
#include "loads.h"

typedef struct hc_loaded_brick {
  hc_brick brick; /* first: see hc_map_by */
  int32_t first;  /* of its loads; they end where the next brick's begin */
  double weight;
  int64_t fluid, boundary; /* particles */
} hc_loaded_brick;

typedef struct hc_bricks {
  hc_loaded_brick *brick; /* ascending, and one more whose `first` is load_count */
  const hc_load *load;    /* ascending by brick, then rank */
  int32_t count, load_count;
  double weight; /* of all */
} hc_bricks;

/* Sorts the loads, which must outlive the bricks, and adds up what lies in one brick. */
void hc_bricks_init(hc_bricks *bricks, hc_load *loads, int64_t count, hc_map_order order);
void hc_bricks_free(hc_bricks *bricks);

/* The axis along which the loads extend the furthest, in bricks. */
int hc_bricks_longest_axis(const hc_load *loads, int64_t count);

/* Slabs: part[k] of brick k, ascending. A brick goes to the part whose share of the total holds the brick's
 * middle. */
void hc_bricks_cut(const hc_bricks *bricks, int parts, int32_t *part);

/* Largest over mean weight of a part; 1 where there is no weight. */
double hc_bricks_imbalance(const hc_bricks *bricks, int parts, const int32_t *part);

/* Largest over mean weight of a rank as the loads lie now. */
double hc_bricks_imbalance_now(const hc_bricks *bricks, int ranks);

/* Renumbers the parts so that few particles have to move: the largest overlaps of a part with what a rank
 * holds are matched first (at least half of what the best matching saves). With `group`, the host of each
 * part as hc_graph_group gives them, parts stay together: groups are first matched to hosts of their size,
 * then parts to the ranks there; null: any part to any rank. Returns how many particles move. */
int64_t hc_bricks_renumber(const hc_bricks *bricks, int ranks, const hc_hosts *hosts, const int32_t *group,
                           int32_t *part);

/* How many particles lie on another rank than their part. */
int64_t hc_bricks_moving(const hc_bricks *bricks, const int32_t *part);

#endif
