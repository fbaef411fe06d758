#include "sample_set.h"

#include "base/check.h"
#include "base/memory.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

static const double wide = 1.4; /* reaches: the edge of a cell, and how far neighbours are looked for */

/* The mixer of splitmix64 (Steele et al. 2014). */
static uint64_t mix(uint64_t bits) {
  bits = (bits ^ bits >> 30) * 0xbf58476d1ce4e5b9u;
  bits = (bits ^ bits >> 27) * 0x94d049bb133111ebu;
  return bits ^ bits >> 31;
}

hc_sample_set hc_sample_set_make(double reach) {
  return (hc_sample_set){.reach = reach, .edge = wide * reach};
}

void hc_sample_set_free(hc_sample_set *set) {
  hc_free(set->at);
  hc_free(set->heads);
  *set = (hc_sample_set){0};
}

hc_sample_candidates hc_sample_candidates_make(int64_t room) {
  return (hc_sample_candidates){.at = hc_alloc((size_t)room, sizeof(hc_sample_candidate)),
                                .room = (size_t)room};
}

void hc_sample_candidates_add(hc_sample_candidates *candidates, const double x[3], int32_t triangle) {
  HC_CHECK((size_t)candidates->count < candidates->room, "room for %zu candidates, no more",
           candidates->room);
  candidates->at[candidates->count++] = (hc_sample_candidate){{x[0], x[1], x[2]}, triangle, -1};
}

void hc_sample_candidates_free(hc_sample_candidates *candidates) {
  hc_free(candidates->at);
  *candidates = (hc_sample_candidates){0};
}

/* --- The grid --- */

static int64_t floor_of(double x) {
  const int64_t whole = (int64_t)x;
  return whole - (x < (double)whole);
}

static void cell_of(const hc_sample_set *set, const double x[3], int64_t cell[3]) {
  for (int a = 0; a < 3; a++) cell[a] = floor_of(x[a] / set->edge);
}

static int32_t *head_of(const hc_sample_set *set, const int64_t cell[3]) {
  const uint64_t bits = (uint64_t)cell[0] * 0x9e3779b97f4a7c15u + (uint64_t)cell[1] * 0xbf58476d1ce4e5b9u +
                        (uint64_t)cell[2] * 0x94d049bb133111ebu;
  return &set->heads[(bits ^ bits >> 32) * 0xd1342543de82ef95u >> 33 & (uint64_t)(set->head_count - 1)];
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

static double square_to(const hc_sample_set *set, int32_t s, const double x[3]) {
  double away[3];
  hc_vector_minus(set->at[s].x, x, away);
  return hc_vector_dot(away, away);
}

/* What is around a point: cells, its own first, and squares of how far off they are at least. */
typedef struct around {
  int64_t middle[3];
  double beyond[3][3]; /* of the cell before, its own and the one behind */
} around;

static around look_around(const hc_sample_set *set, const double x[3]) {
  around here;
  cell_of(set, x, here.middle);
  for (int a = 0; a < 3; a++) {
    const double within = x[a] - (double)here.middle[a] * set->edge, left = set->edge - within;
    here.beyond[a][0] = within * within;
    here.beyond[a][1] = 0;
    here.beyond[a][2] = left * left;
  }
  return here;
}

/* The first sample of the chain that holds the n-th cell's, -1 if there is none or all are farther. */
static int32_t first_of(const hc_sample_set *set, const around *here, int n, double square) {
  const int at = n == 0 ? 13 : n <= 13 ? n - 1 : n, i = at % 3, j = at / 3 % 3, k = at / 9;
  if ((here->beyond[0][i] + here->beyond[1][j] + here->beyond[2][k]) * (1 - 1e-9) > square) return -1;
  return *head_of(
      set, (const int64_t[3]){here->middle[0] + i - 1, here->middle[1] + j - 1, here->middle[2] + k - 1});
}

/* The nearest sample within the set's reach, or -1; of several as near the first. `*square`: how near. */
static int32_t find_nearest(const hc_sample_set *set, const double x[3], double *square) {
  int32_t found = -1;
  *square = set->reach * set->reach;
  if (set->count == 0) return -1;
  const around here = look_around(set, x);
  for (int n = 0; n < 27; n++)
    for (int32_t s = first_of(set, &here, n, *square); s >= 0; s = set->at[s].next) {
      const double away = square_to(set, s, x);
      if (away > *square || (away == *square && (found < 0 || s >= found))) continue;
      *square = away;
      found = s;
    }
  return found;
}

/* A sample closer than `distance`, at most the reach, or -1. */
static int32_t find_within(const hc_sample_set *set, const double x[3], double distance) {
  const double square = distance * distance;
  if (set->count == 0) return -1;
  const around here = look_around(set, x);
  for (int n = 0; n < 27; n++)
    for (int32_t s = first_of(set, &here, n, square); s >= 0; s = set->at[s].next)
      if (square_to(set, s, x) < square) return s;
  return -1;
}
bool hc_sample_set_any_within(const hc_sample_set *set, const double x[3], double distance) {
  return find_within(set, x, distance) >= 0;
}

/* --- Neighbours among samples --- */

/* The others nearer than an edge: those of a sample are `count` of `with` from `first` on. They are looked
 * for when they are asked for, -1 before that, so that what is near in space lies together. What is nearer to
 * a sample than half the way to the nearest of them is nearer to no other. */
typedef struct near {
  double nearest; /* square */
  int32_t first, count;
} near;

typedef struct neighbors {
  near *of; /* each sample */
  int32_t *with, end;
  size_t room;
  double most; /* square of an edge */
} neighbors;

static neighbors no_neighbors(const hc_sample_set *set) {
  neighbors n = {.of = hc_alloc((size_t)set->count, sizeof *n.of), .most = set->edge * set->edge};
  for (int32_t s = 0; s < set->count; s++) n.of[s].first = -1;
  return n;
}

static void free_neighbors(neighbors *n) {
  hc_free(n->of);
  hc_free(n->with);
}

static const near *neighbors_of(const hc_sample_set *set, neighbors *n, int32_t s) {
  near *const found = &n->of[s];
  if (found->first >= 0) return found;
  const double *const x = set->at[s].x;
  const around here = look_around(set, x);
  *found = (near){n->most, n->end, 0};
  for (int cell = 0; cell < 27; cell++)
    for (int32_t other = first_of(set, &here, cell, n->most); other >= 0; other = set->at[other].next) {
      const double square = square_to(set, other, x);
      if (square >= n->most || other == s) continue;
      hc_reserve((void **)&n->with, &n->room, 2 * (size_t)n->end + 1, (size_t)n->end, sizeof *n->with);
      n->with[n->end++] = other;
      found->count++;
      if (square < found->nearest) found->nearest = square;
    }
  return found;
}

/* As find_nearest; from a guess (-1: none) to its neighbours as long as that comes nearer. */
static int32_t find_nearest_from(const hc_sample_set *set, neighbors *n, const double x[3], int32_t guess) {
  double square;
  if (guess < 0) return find_nearest(set, x, &square);
  square = square_to(set, guess, x);
  for (;;) {
    const near *const around = neighbors_of(set, n, guess);
    if (4 * square * (1 + 1e-9) < around->nearest) break;
    int32_t next = guess;
    for (int32_t k = around->first; k < around->first + around->count; k++) {
      const int32_t other = n->with[k];
      const double away = square_to(set, other, x);
      if (away > square || (away == square && other >= next)) continue;
      square = away;
      next = other;
    }
    if (next == guess) {
      if (4 * square * (1 + 1e-9) < n->most) break;
      return find_nearest(set, x, &square);
    }
    guess = next;
  }
  return square < set->reach * set->reach ? guess : -1;
}

/* --- Choosing and evening out --- */

void hc_sample_set_choose(hc_sample_set *set, hc_sample_candidates *candidates, double distance) {
  int32_t *const order = hc_alloc((size_t)candidates->count, sizeof *order);
  for (int32_t k = 0; k < candidates->count; k++) { /* shuffled, by Fisher and Yates */
    const int32_t other = (int32_t)(mix((uint64_t)k * 0x9e3779b97f4a7c15u) % (uint64_t)(k + 1));
    order[k] = k;
    order[k] = order[other];
    order[other] = k;
  }
  for (int32_t k = 0; k < candidates->count; k++) {
    hc_sample_candidate *const candidate = &candidates->at[order[k]];
    candidate->nearest = find_within(set, candidate->x, distance);
    if (candidate->nearest >= 0) continue;
    candidate->nearest = set->count;
    hc_sample_set_add(set, candidate->x, NULL, candidate->triangle);
  }
  hc_free(order);
}

/* The mean of a sample's candidates, and the one that is nearest to it. */
typedef struct cluster {
  double mean[3], nearest;
  int32_t count, best;
} cluster;

/* Those that are nearest to each sample, with their sum. */
static void gather_clusters(const hc_sample_set *set, hc_sample_candidates *candidates, cluster *clusters) {
  neighbors n = no_neighbors(set);
  for (int32_t k = 0; k < candidates->count; k++) {
    hc_sample_candidate *const candidate = &candidates->at[k];
    candidate->nearest = find_nearest_from(set, &n, candidate->x, candidate->nearest);
    if (candidate->nearest < 0) continue;
    cluster *const c = &clusters[candidate->nearest];
    for (int a = 0; a < 3; a++) c->mean[a] += candidate->x[a];
    c->count++;
  }
  free_neighbors(&n);
}

void hc_sample_set_even_out(hc_sample_set *set, hc_sample_candidates *candidates) {
  cluster *const clusters = hc_alloc_zero((size_t)set->count, sizeof *clusters);
  gather_clusters(set, candidates, clusters);
  for (int32_t s = 0; s < set->count; s++) {
    for (int a = 0; a < 3; a++) clusters[s].mean[a] /= clusters[s].count;
    clusters[s].nearest = INFINITY;
  }
  for (int32_t k = 0; k < candidates->count; k++) {
    const hc_sample_candidate *const candidate = &candidates->at[k];
    if (candidate->nearest < 0) continue;
    cluster *const c = &clusters[candidate->nearest];
    double square = 0;
    for (int a = 0; a < 3; a++) {
      const double away = candidate->x[a] - c->mean[a];
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

void hc_sample_set_thin_out(hc_sample_set *set, hc_sample_candidates *candidates, double distance) {
  const int32_t count = set->count;
  int32_t *const place = hc_alloc((size_t)count, sizeof *place); /* where samples come to */
  for (int32_t k = 0; k < set->fixed; k++) place[k] = k;
  set->count = set->fixed;
  link_all(set);
  for (int32_t k = set->fixed; k < count; k++) {
    const hc_sample sample = set->at[k];
    place[k] = find_within(set, sample.x, distance);
    if (place[k] >= 0) continue;
    place[k] = set->count;
    hc_sample_set_add(set, sample.x, NULL, sample.triangle);
  }
  for (int32_t k = 0; k < candidates->count; k++) {
    int32_t *const nearest = &candidates->at[k].nearest;
    if (*nearest >= 0) *nearest = place[*nearest];
  }
  hc_free(place);
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
    const hc_sample_candidate *const candidate = &candidates->at[k];
    double square;
    if (candidate->nearest >= 0 && square_to(set, candidate->nearest, candidate->x) <= distance * distance)
      continue;
    const int32_t near = find_nearest(set, candidate->x, &square);
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
