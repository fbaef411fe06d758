#include "bricks.h"

#include "base/check.h"
#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

void hc_bricks_init(hc_bricks *bricks, hc_load *loads, int64_t count, hc_map_order order) {
  HC_CHECK(count < INT32_MAX, "too many bricks on all ranks: %lld", (long long)count);
  if (count > 0) qsort(loads, (size_t)count, sizeof *loads, hc_map_by(order));
  *bricks = (hc_bricks){hc_alloc((size_t)count + 1, sizeof *bricks->brick), loads, 0, (int32_t)count, 0.0};
  for (int32_t k = 0; k < bricks->load_count; k++) {
    hc_loaded_brick *brick = &bricks->brick[bricks->count];
    if (bricks->count == 0 || !hc_brick_equal(loads[k].brick, brick[-1].brick)) {
      *brick = (hc_loaded_brick){.brick = loads[k].brick, .first = k};
      bricks->count++;
    } else {
      brick--;
    }
    brick->weight += loads[k].weight;
    brick->fluid += loads[k].fluid;
    brick->boundary += loads[k].boundary;
  }
  bricks->brick[bricks->count] = (hc_loaded_brick){.first = bricks->load_count};
  for (int32_t k = 0; k < bricks->count; k++) bricks->weight += bricks->brick[k].weight;
}

void hc_bricks_free(hc_bricks *bricks) {
  hc_free(bricks->brick);
  memset(bricks, 0, sizeof *bricks);
}

int hc_bricks_longest_axis(const hc_load *loads, int64_t count) {
  int32_t low[3] = {0, 0, 0}, high[3] = {0, 0, 0};
  for (int64_t k = 0; k < count; k++) {
    for (int axis = 0; axis < 3; axis++) {
      const int32_t x = loads[k].brick.x[axis];
      if (k == 0 || x < low[axis]) low[axis] = x;
      if (k == 0 || x > high[axis]) high[axis] = x;
    }
  }
  int longest = 0;
  for (int axis = 1; axis < 3; axis++)
    if ((int64_t)high[axis] - low[axis] > (int64_t)high[longest] - low[longest]) longest = axis;
  return longest;
}

void hc_bricks_cut(const hc_bricks *bricks, int parts, int32_t *part) {
  double before = 0.0;
  for (int32_t k = 0; k < bricks->count; k++) {
    const double weight = bricks->brick[k].weight;
    const int32_t owner = (int32_t)((before + 0.5 * weight) * parts / bricks->weight);
    part[k] = owner < parts ? owner : parts - 1;
    before += weight;
  }
}

static double largest_over_mean(const double *weight, int count) {
  double largest = 0.0, total = 0.0;
  for (int k = 0; k < count; k++) {
    total += weight[k];
    if (weight[k] > largest) largest = weight[k];
  }
  return total > 0.0 ? largest * count / total : 1.0;
}

double hc_bricks_imbalance(const hc_bricks *bricks, int parts, const int32_t *part) {
  double *weight = hc_alloc_zero((size_t)parts, sizeof *weight);
  for (int32_t k = 0; k < bricks->count; k++) weight[part[k]] += bricks->brick[k].weight;
  const double imbalance = largest_over_mean(weight, parts);
  hc_free(weight);
  return imbalance;
}

double hc_bricks_imbalance_now(const hc_bricks *bricks, int ranks) {
  double *weight = hc_alloc_zero((size_t)ranks, sizeof *weight);
  for (int32_t k = 0; k < bricks->load_count; k++) weight[bricks->load[k].rank] += bricks->load[k].weight;
  const double imbalance = largest_over_mean(weight, ranks);
  hc_free(weight);
  return imbalance;
}

/* ---- parts to ranks ---- */

/* Particles of a part that a rank holds. */
typedef struct overlap {
  int32_t part, rank;
  int64_t particles;
} overlap;

static int by_pair(const void *a, const void *b) {
  const overlap *p = a, *q = b;
  if (p->part != q->part) return p->part < q->part ? -1 : 1;
  return p->rank < q->rank ? -1 : p->rank > q->rank;
}

static int by_size(const void *a, const void *b) {
  const overlap *p = a, *q = b;
  if (p->particles != q->particles) return p->particles > q->particles ? -1 : 1;
  return by_pair(a, b);
}

/* Adds up overlaps of one pair, and puts the largest first; returns how many are left. */
static int32_t add_up(overlap *overlaps, int32_t count) {
  int32_t left = 0;
  qsort(overlaps, (size_t)count, sizeof *overlaps, by_pair);
  for (int32_t l = 0; l < count; l++) {
    if (left > 0 && by_pair(&overlaps[left - 1], &overlaps[l]) == 0)
      overlaps[left - 1].particles += overlaps[l].particles;
    else
      overlaps[left++] = overlaps[l];
  }
  qsort(overlaps, (size_t)left, sizeof *overlaps, by_size);
  return left;
}

static int32_t find_overlaps(const hc_bricks *bricks, const int32_t *part, overlap *overlaps) {
  for (int32_t k = 0; k < bricks->count; k++)
    for (int32_t l = bricks->brick[k].first; l < bricks->brick[k + 1].first; l++)
      overlaps[l] =
          (overlap){part[k], bricks->load[l].rank, (int64_t)bricks->load[l].fluid + bricks->load[l].boundary};
  return bricks->load_count > 0 ? add_up(overlaps, bricks->load_count) : 0;
}

/* Gives each of `count` parts a rank of the same kind, those with the largest overlaps first. */
static void match(const overlap *overlaps, int32_t overlap_count, int count, const int32_t *kind_of_part,
                  const int32_t *kind_of_rank, int32_t *rank_of) {
  bool *taken = hc_alloc_zero((size_t)count, sizeof *taken);
  for (int k = 0; k < count; k++) rank_of[k] = -1;
  for (int32_t k = 0; k < overlap_count; k++) {
    const overlap *next = &overlaps[k];
    if (rank_of[next->part] >= 0 || taken[next->rank] ||
        (kind_of_part && kind_of_part[next->part] != kind_of_rank[next->rank]))
      continue;
    rank_of[next->part] = next->rank;
    taken[next->rank] = true;
  }
  for (int k = 0, first = 0; k < count; k++) {
    if (rank_of[k] >= 0) continue;
    while (taken[first]) first++;
    int rank = first;
    while (kind_of_part && (taken[rank] || kind_of_part[k] != kind_of_rank[rank])) rank++;
    rank_of[k] = rank;
    taken[rank] = true;
  }
  hc_free(taken);
}

/* The host of each part, groups matched to hosts of their size. */
static void match_hosts(const overlap *overlaps, int32_t count, int ranks, const hc_hosts *hosts,
                        const int32_t *group, int32_t *host_of) {
  overlap *whole = hc_alloc((size_t)count + 1, sizeof *whole);
  for (int32_t k = 0; k < count; k++)
    whole[k] = (overlap){group[overlaps[k].part], hosts->of[overlaps[k].rank], overlaps[k].particles};
  const int32_t left = count > 0 ? add_up(whole, count) : 0;
  int32_t *host = hc_alloc((size_t)hosts->count, sizeof *host);
  match(whole, left, hosts->count, hosts->size, hosts->size, host);
  for (int p = 0; p < ranks; p++) host_of[p] = host[group[p]];
  hc_free(host);
  hc_free(whole);
}

int64_t hc_bricks_renumber(const hc_bricks *bricks, int ranks, const hc_hosts *hosts, const int32_t *group,
                           int32_t *part) {
  overlap *overlaps = hc_alloc((size_t)bricks->load_count + 1, sizeof *overlaps);
  const int32_t count = find_overlaps(bricks, part, overlaps);
  int32_t *rank_of = hc_alloc((size_t)ranks, sizeof *rank_of),
          *host_of = group ? hc_alloc((size_t)ranks, sizeof *host_of) : NULL;
  if (group) match_hosts(overlaps, count, ranks, hosts, group, host_of);
  match(overlaps, count, ranks, host_of, group ? hosts->of : NULL, rank_of);
  for (int32_t k = 0; k < bricks->count; k++) part[k] = rank_of[part[k]];
  hc_free(host_of);
  hc_free(rank_of);
  hc_free(overlaps);
  return hc_bricks_moving(bricks, part);
}

int64_t hc_bricks_moving(const hc_bricks *bricks, const int32_t *part) {
  int64_t moving = 0;
  for (int32_t k = 0; k < bricks->count; k++)
    for (int32_t l = bricks->brick[k].first; l < bricks->brick[k + 1].first; l++)
      if (bricks->load[l].rank != part[k])
        moving += (int64_t)bricks->load[l].fluid + bricks->load[l].boundary;
  return moving;
}
