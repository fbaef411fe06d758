#include "sample_set.h"

#include "base/memory.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

/* The mixer of splitmix64 (Steele et al. 2014). */
static uint64_t mix(uint64_t bits) {
  bits = (bits ^ bits >> 30) * 0xbf58476d1ce4e5b9u;
  bits = (bits ^ bits >> 27) * 0x94d049bb133111ebu;
  return bits ^ bits >> 31;
}

hc_sample_set hc_sample_set_make(double cell) {
  return (hc_sample_set){.cell = cell};
}

void hc_sample_set_free(hc_sample_set *set) {
  hc_free(set->at);
  hc_free(set->heads);
  *set = (hc_sample_set){0};
}

void hc_sample_candidates_free(hc_sample_candidates *candidates) {
  hc_free(candidates->at);
  *candidates = (hc_sample_candidates){0};
}

void hc_sample_candidates_add(hc_sample_candidates *candidates, const double x[3], int32_t triangle) {
  const size_t count = (size_t)candidates->count;
  hc_reserve((void **)&candidates->at, &candidates->room, count + 1, count, sizeof *candidates->at);
  candidates->at[candidates->count++] = (hc_sample_candidate){{x[0], x[1], x[2]}, triangle, -1};
}

/* --- The grid --- */

static void cell_of(const hc_sample_set *set, const double x[3], int64_t cell[3]) {
  for (int a = 0; a < 3; a++) cell[a] = (int64_t)floor(x[a] / set->cell);
}

static int32_t *head_of(const hc_sample_set *set, const int64_t cell[3]) {
  const uint64_t bits = mix((uint64_t)cell[0] + mix((uint64_t)cell[1] + mix((uint64_t)cell[2] + 1)));
  return &set->heads[bits & (uint64_t)(set->head_count - 1)];
}

static void link_sample(hc_sample_set *set, int32_t k) {
  int64_t cell[3];
  cell_of(set, set->at[k].x, cell);
  int32_t *const head = head_of(set, cell);
  set->at[k].next = *head;
  *head = k;
}

/* All samples into a grid of their number. */
static void link_all(hc_sample_set *set) {
  int32_t wanted = 64;
  while (wanted < set->count) wanted *= 2;
  wanted *= 2;
  if (wanted > set->head_count) {
    hc_free(set->heads);
    set->heads = hc_alloc((size_t)wanted, sizeof *set->heads);
    set->head_count = wanted;
  }
  for (int32_t k = 0; k < set->head_count; k++) set->heads[k] = -1;
  for (int32_t k = 0; k < set->count; k++) link_sample(set, k);
}

void hc_sample_set_add(hc_sample_set *set, const double x[3], const double normal[3], int32_t triangle) {
  const size_t count = (size_t)set->count;
  hc_reserve((void **)&set->at, &set->room, 2 * count + 1, count, sizeof *set->at);
  hc_sample *const added = &set->at[set->count++];
  *added = (hc_sample){.triangle = triangle};
  for (int a = 0; a < 3; a++) {
    added->x[a] = x[a];
    added->normal[a] = normal ? normal[a] : 0;
  }
  if (set->count > set->head_count / 2)
    link_all(set);
  else
    link_sample(set, set->count - 1);
}

/* The nearest sample within `distance`, at most a cell, or -1; of several as near the first. `guess`: a
 * sample that may be near, or -1: it saves looking at others. `*square`: how near. */
static int32_t find_nearest(const hc_sample_set *set, const double x[3], double distance, int32_t guess,
                            double *square) {
  int32_t found = -1;
  int64_t middle[3];
  double beyond[3][3]; /* squares of how far the cell before, its own and the one behind are */
  *square = distance * distance;
  if (set->count == 0) return -1;
  if (guess >= 0 && guess < set->count) {
    double away[3];
    hc_vector_minus(set->at[guess].x, x, away);
    const double here = hc_vector_dot(away, away);
    if (here <= *square) {
      *square = here;
      found = guess;
    }
  }
  cell_of(set, x, middle);
  for (int a = 0; a < 3; a++) {
    const double within = x[a] - (double)middle[a] * set->cell, left = set->cell - within;
    beyond[a][0] = within * within;
    beyond[a][1] = 0;
    beyond[a][2] = left * left;
  }
  for (int n = 0; n < 27; n++) { /* its own cell first */
    const int at = n == 0 ? 13 : n <= 13 ? n - 1 : n, i = at % 3, j = at / 3 % 3, k = at / 9;
    if ((beyond[0][i] + beyond[1][j] + beyond[2][k]) * (1 - 1e-9) > *square) continue;
    const int64_t cell[3] = {middle[0] + i - 1, middle[1] + j - 1, middle[2] + k - 1};
    for (int32_t s = *head_of(set, cell); s >= 0; s = set->at[s].next) {
      double away[3];
      hc_vector_minus(set->at[s].x, x, away);
      const double here = hc_vector_dot(away, away);
      if (here > *square || (here == *square && (found < 0 || s >= found))) continue;
      *square = here;
      found = s;
    }
  }
  return found;
}

bool hc_sample_set_any_within(const hc_sample_set *set, const double x[3], double distance) {
  double square;
  return find_nearest(set, x, distance, -1, &square) >= 0;
}

/* --- Choosing and evening out --- */

void hc_sample_set_choose(hc_sample_set *set, const hc_sample_candidates *candidates, double distance) {
  int32_t *const order = hc_alloc((size_t)candidates->count, sizeof *order);
  for (int32_t k = 0; k < candidates->count; k++) { /* shuffled, by Fisher and Yates */
    const int32_t other = (int32_t)(mix((uint64_t)k * 0x9e3779b97f4a7c15u) % (uint64_t)(k + 1));
    order[k] = k;
    order[k] = order[other];
    order[other] = k;
  }
  for (int32_t k = 0; k < candidates->count; k++) {
    const hc_sample_candidate *const candidate = &candidates->at[order[k]];
    if (!hc_sample_set_any_within(set, candidate->x, distance))
      hc_sample_set_add(set, candidate->x, NULL, candidate->triangle);
  }
  hc_free(order);
}

/* The mean of a sample's candidates, and the one that is nearest to it. */
typedef struct cluster {
  double sum[3], nearest;
  int32_t count, best;
} cluster;

void hc_sample_set_even_out(hc_sample_set *set, hc_sample_candidates *candidates) {
  cluster *const clusters = hc_alloc_zero((size_t)set->count, sizeof *clusters);
  for (int32_t k = 0; k < candidates->count; k++) {
    hc_sample_candidate *const candidate = &candidates->at[k];
    double square;
    candidate->nearest = find_nearest(set, candidate->x, set->cell, candidate->nearest, &square);
    if (candidate->nearest < 0) continue;
    cluster *const c = &clusters[candidate->nearest];
    for (int a = 0; a < 3; a++) c->sum[a] += candidate->x[a];
    c->count++;
    c->nearest = INFINITY;
  }
  for (int32_t k = 0; k < candidates->count; k++) {
    const hc_sample_candidate *const candidate = &candidates->at[k];
    if (candidate->nearest < 0) continue;
    cluster *const c = &clusters[candidate->nearest];
    double square = 0;
    for (int a = 0; a < 3; a++) {
      const double away = candidate->x[a] - c->sum[a] / c->count;
      square += away * away;
    }
    if (square >= c->nearest) continue;
    c->nearest = square;
    c->best = k;
  }
  for (int32_t s = set->fixed; s < set->count; s++) {
    if (clusters[s].count == 0) continue;
    const hc_sample_candidate *const best = &candidates->at[clusters[s].best];
    memcpy(set->at[s].x, best->x, sizeof best->x);
    set->at[s].triangle = best->triangle;
  }
  hc_free(clusters);
  link_all(set);
}

void hc_sample_set_thin_out(hc_sample_set *set, double distance) {
  const int32_t count = set->count;
  set->count = set->fixed;
  link_all(set);
  for (int32_t k = set->fixed; k < count; k++) {
    const hc_sample sample = set->at[k];
    if (!hc_sample_set_any_within(set, sample.x, distance))
      hc_sample_set_add(set, sample.x, NULL, sample.triangle);
  }
}

typedef struct gap {
  double square;
  int32_t candidate;
} gap;

static int by_gap(const void *left, const void *right) {
  const gap *const a = left, *const b = right;
  if (a->square != b->square) return a->square > b->square ? -1 : 1;
  return (a->candidate > b->candidate) - (a->candidate < b->candidate);
}

void hc_sample_set_fill(hc_sample_set *set, const hc_sample_candidates *candidates, double distance) {
  gap *gaps = NULL;
  size_t room = 0, count = 0;
  for (int32_t k = 0; k < candidates->count; k++) {
    double square;
    const int32_t near =
        find_nearest(set, candidates->at[k].x, set->cell, candidates->at[k].nearest, &square);
    if (near >= 0 && square <= distance * distance) continue;
    hc_reserve((void **)&gaps, &room, 2 * count + 1, count, sizeof *gaps);
    gaps[count++] = (gap){near >= 0 ? square : INFINITY, k};
  }
  if (count > 0) qsort(gaps, count, sizeof *gaps, by_gap);
  for (size_t k = 0; k < count; k++) {
    const hc_sample_candidate *const candidate = &candidates->at[gaps[k].candidate];
    if (!hc_sample_set_any_within(set, candidate->x, distance))
      hc_sample_set_add(set, candidate->x, NULL, candidate->triangle);
  }
  hc_free(gaps);
}
