#include "sample_choice.h"

#include "base/check.h"
#include "base/memory.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { FIRST_DRAW = 64, GROWTH = 4 }; /* the first draw's part of all candidates; each is so much larger */

hc_sample_candidates hc_sample_candidates_make(int64_t room) {
  return (hc_sample_candidates){.at = hc_alloc((size_t)room, sizeof(hc_sample_candidate)),
                                .room = (size_t)room};
}

void hc_sample_candidates_free(hc_sample_candidates *candidates) {
  hc_free(candidates->at);
  *candidates = (hc_sample_candidates){0};
}

void hc_sample_candidates_add(hc_sample_candidates *candidates, const double x[3], int32_t triangle) {
  HC_CHECK((size_t)candidates->count < candidates->room, "room for %zu candidates, no more",
           candidates->room);
  candidates->at[candidates->count++] = (hc_sample_candidate){{x[0], x[1], x[2]}, triangle, -1};
}

void hc_sample_candidates_number(hc_sample_candidates *candidates, const hc_parts *parts) {
  size_t count = 1;
  int64_t *counts = hc_alloc(count, sizeof *counts);
  counts[0] = candidates->count;
  hc_parts_gather(parts, (void **)&counts, &count, sizeof *counts);
  candidates->first = candidates->all = 0;
  for (int part = 0; part < parts->count; part++) {
    if (part < parts->part) candidates->first += counts[part];
    candidates->all += counts[part];
  }
  hc_free(counts);
}

static void note_change(hc_sample_set *set, const double x[3]) {
  hc_reserve((void **)&set->changed, &set->changed_room, 2 * set->changed_count + 1, set->changed_count,
             sizeof *set->changed);
  memcpy(set->changed[set->changed_count++], x, sizeof *set->changed);
}

/* --- The first choice --- */

/* The mixer of splitmix64 (Steele et al. 2014). */
static uint64_t mix(uint64_t bits) {
  bits = (bits ^ bits >> 30) * 0xbf58476d1ce4e5b9u;
  bits = (bits ^ bits >> 27) * 0x94d049bb133111ebu;
  return bits ^ bits >> 31;
}

static int32_t turn_of(const hc_sample_candidate *candidate) {
  return -2 - candidate->nearest;
}

/* Gives each candidate its turn, which is at `nearest` as long as it has not come: below -1. Shuffled by
 * Fisher and Yates. */
static void shuffle(hc_sample_candidates *candidates) {
  int32_t *const order = hc_alloc((size_t)candidates->all, sizeof *order);
  for (int32_t k = 0; k < candidates->all; k++) {
    const int32_t other = (int32_t)(mix((uint64_t)k * 0x9e3779b97f4a7c15u) % (uint64_t)(k + 1));
    order[k] = k;
    order[k] = order[other];
    order[other] = k;
  }
  for (int32_t k = 0; k < candidates->all; k++) {
    const int64_t own = order[k] - candidates->first;
    if (own >= 0 && own < candidates->count) candidates->at[own].nearest = -2 - k;
  }
  hc_free(order);
}

/* A candidate whose turn has come, with no sample of the draws before in its way. */
typedef struct contender {
  double x[3];
  int32_t turn, triangle;
} contender;

static int by_turn(const void *left, const void *right) {
  const contender *const a = left, *const b = right;
  return (a->turn > b->turn) - (a->turn < b->turn);
}

/* Takes turns below `end`, of those that had none before. */
static void draw(hc_sample_set *set, hc_sample_candidates *candidates, int64_t end, double distance,
                 const hc_parts *parts) {
  contender *contenders = hc_alloc(0, sizeof *contenders);
  int32_t *own = NULL;
  size_t room = 0, own_room = 0, count = 0, own_count = 0;
  for (int32_t k = 0; k < candidates->count; k++) {
    hc_sample_candidate *const c = &candidates->at[k];
    const int32_t turn = turn_of(c);
    if (turn < 0 || turn >= end) continue;
    const int32_t near = hc_sample_set_within(set, c->x, distance);
    if (near >= 0) {
      c->nearest = near;
      continue;
    }
    hc_reserve((void **)&contenders, &room, 2 * count + 1, count, sizeof *contenders);
    hc_reserve((void **)&own, &own_room, 2 * own_count + 1, own_count, sizeof *own);
    contenders[count++] = (contender){{c->x[0], c->x[1], c->x[2]}, turn, c->triangle};
    own[own_count++] = k;
  }
  hc_parts_gather(parts, (void **)&contenders, &count, sizeof *contenders);
  if (count > 0) qsort(contenders, count, sizeof *contenders, by_turn);
  for (size_t k = 0; k < count; k++)
    if (hc_sample_set_within(set, contenders[k].x, distance) < 0)
      hc_sample_set_add(set, contenders[k].x, contenders[k].triangle);
  for (size_t k = 0; k < own_count; k++)
    candidates->at[own[k]].nearest = hc_sample_set_within(set, candidates->at[own[k]].x, distance);
  hc_free(contenders);
  hc_free(own);
}

void hc_sample_choice_first(hc_sample_set *set, hc_sample_candidates *candidates, double distance,
                            const hc_parts *parts) {
  shuffle(candidates);
  int64_t end = candidates->all / FIRST_DRAW;
  for (; end < candidates->all; end = GROWTH * end + 1) draw(set, candidates, end, distance, parts);
  draw(set, candidates, candidates->all, distance, parts);
  for (int32_t s = 0; s < set->count; s++) note_change(set, set->at[s].x);
}

/* --- Evening out --- */

/* The mean of a sample's candidates, and the one that is nearest to it. */
typedef struct cluster {
  double mean[3]; /* the sum, until set_mean */
  double nearest; /* square; 0 until then */
  int32_t count, best;
} cluster;

/* A candidate of a cluster that several parts have candidates of. */
typedef struct member {
  double x[3];
  int32_t sample, triangle;
} member;

/* Where a sample moves to. */
typedef member move;

static void add_to_mean(cluster *c, const double x[3]) {
  for (int a = 0; a < 3; a++) c->mean[a] += x[a];
  c->count++;
}

static void set_mean(cluster *c) {
  if (c->count == 0 || c->nearest > 0) return;
  for (int a = 0; a < 3; a++) c->mean[a] /= c->count;
  c->nearest = INFINITY;
}

static void look_for_best(cluster *c, const double x[3], int32_t k) {
  double square = 0;
  for (int a = 0; a < 3; a++) {
    const double away = x[a] - c->mean[a];
    square += away * away;
  }
  if (square >= c->nearest) return;
  c->nearest = square;
  c->best = k;
}

/* A bit for each cell of two reaches, by a hash: cells may share one. */
static uint64_t cell_bit(const hc_sample_set *set, const double x[3], int n) {
  uint64_t bits = 0;
  for (int a = 0; a < 3; a++, n /= 3)
    bits = mix(bits + (uint64_t)((int64_t)floor(x[a] / (2 * set->reach)) + n % 3 - 1));
  return bits % ((uint64_t)set->head_count * 16);
}

/* The samples that may have other candidates than a round ago, and no fewer: who loses one to another, or
 * gets it, is within two reaches of a change. Freed with hc_free. */
static bool *find_unsettled(hc_sample_set *set) {
  bool *const marked = hc_alloc_zero((size_t)set->head_count * 16, sizeof *marked),
              *const unsettled = hc_alloc((size_t)set->count, sizeof *unsettled);
  for (size_t k = 0; k < set->changed_count; k++)
    for (int n = 0; n < 27; n++) marked[cell_bit(set, set->changed[k], n)] = true;
  for (int32_t s = 0; s < set->count; s++) unsettled[s] = marked[cell_bit(set, set->at[s].x, 13)];
  hc_free(marked);
  set->changed_count = 0;
  return unsettled;
}

/* Of the unsettled samples: the others' have not changed, and they stay where they are. */
static void gather_clusters(const hc_sample_set *set, hc_sample_candidates *candidates, const bool *unsettled,
                            cluster *clusters) {
  hc_sample_neighbors n = hc_sample_neighbors_make(set);
  for (int32_t k = 0; k < candidates->count; k++) {
    hc_sample_candidate *const c = &candidates->at[k];
    if (c->nearest >= 0 && !unsettled[c->nearest]) continue;
    c->nearest = hc_sample_neighbors_nearest(set, &n, c->x, c->nearest);
    if (c->nearest >= 0) add_to_mean(&clusters[c->nearest], c->x);
  }
  hc_sample_neighbors_free(&n);
}

/* How many parts have candidates of each sample; freed with hc_free. Null if there is but one part. */
static int32_t *count_parts(const hc_sample_set *set, const cluster *clusters, const hc_parts *parts) {
  if (parts->count == 1) return NULL;
  size_t count = 0;
  int32_t *const times = hc_alloc_zero((size_t)set->count, sizeof *times),
                 *touched = hc_alloc((size_t)set->count, sizeof *touched);
  for (int32_t s = set->fixed; s < set->count; s++)
    if (clusters[s].count > 0) touched[count++] = s;
  hc_parts_gather(parts, (void **)&touched, &count, sizeof *touched);
  for (size_t k = 0; k < count; k++) times[touched[k]]++;
  hc_free(touched);
  return times;
}

static void add_move(move **moves, size_t *count, size_t *room, const move *added) {
  hc_reserve((void **)moves, room, 2 * *count + 1, *count, sizeof **moves);
  (*moves)[(*count)++] = *added;
}

/* Moves the samples that only one part has candidates of. */
static void move_own(hc_sample_set *set, const hc_sample_candidates *candidates, cluster *clusters,
                     const int32_t *times, const hc_parts *parts) {
  move *moves = hc_alloc(0, sizeof *moves);
  size_t count = 0, room = 0;
  for (int32_t s = set->fixed; s < set->count; s++) set_mean(&clusters[s]);
  for (int32_t k = 0; k < candidates->count; k++) {
    const hc_sample_candidate *const c = &candidates->at[k];
    if (c->nearest >= set->fixed && clusters[c->nearest].count > 0)
      look_for_best(&clusters[c->nearest], c->x, k);
  }
  for (int32_t s = set->fixed; s < set->count; s++) {
    if (clusters[s].count == 0 || (times && times[s] > 1)) continue;
    const hc_sample_candidate *const best = &candidates->at[clusters[s].best];
    if (best->triangle == set->at[s].triangle && memcmp(best->x, set->at[s].x, sizeof best->x) == 0) continue;
    add_move(&moves, &count, &room, &(move){{best->x[0], best->x[1], best->x[2]}, s, best->triangle});
  }
  hc_parts_gather(parts, (void **)&moves, &count, sizeof *moves);
  for (size_t k = 0; k < count; k++) {
    hc_sample *const sample = &set->at[moves[k].sample];
    note_change(set, sample->x);
    note_change(set, moves[k].x);
    memcpy(sample->x, moves[k].x, sizeof sample->x);
    sample->triangle = moves[k].triangle;
  }
  hc_free(moves);
}

/* Moves the others: every part does it for itself, among the candidates of all. */
static void move_shared(hc_sample_set *set, const hc_sample_candidates *candidates, cluster *clusters,
                        const int32_t *times, const hc_parts *parts) {
  member *members = hc_alloc(0, sizeof *members);
  size_t count = 0, room = 0;
  for (int32_t k = 0; k < candidates->count; k++) {
    const hc_sample_candidate *const c = &candidates->at[k];
    if (c->nearest < set->fixed || times[c->nearest] < 2) continue; /* none of settled ones */
    add_move(&members, &count, &room, &(member){{c->x[0], c->x[1], c->x[2]}, c->nearest, c->triangle});
  }
  hc_parts_gather(parts, (void **)&members, &count, sizeof *members);
  for (size_t k = 0; k < count; k++) clusters[members[k].sample] = (cluster){.count = 0};
  for (size_t k = 0; k < count; k++) add_to_mean(&clusters[members[k].sample], members[k].x);
  for (size_t k = 0; k < count; k++) set_mean(&clusters[members[k].sample]);
  for (size_t k = 0; k < count; k++) look_for_best(&clusters[members[k].sample], members[k].x, (int32_t)k);
  for (size_t k = 0; k < count; k++) {
    const member *const best = &members[clusters[members[k].sample].best];
    hc_sample *const sample = &set->at[best->sample];
    if (memcmp(best->x, sample->x, sizeof best->x) != 0) {
      note_change(set, sample->x);
      note_change(set, best->x);
    }
    memcpy(sample->x, best->x, sizeof sample->x);
    sample->triangle = best->triangle;
  }
  hc_free(members);
}

void hc_sample_choice_even_out(hc_sample_set *set, hc_sample_candidates *candidates, const hc_parts *parts) {
  cluster *const clusters = hc_alloc_zero((size_t)set->count, sizeof *clusters);
  bool *const unsettled = find_unsettled(set);
  gather_clusters(set, candidates, unsettled, clusters);
  hc_free(unsettled);
  int32_t *const times = count_parts(set, clusters, parts);
  move_own(set, candidates, clusters, times, parts);
  if (times) move_shared(set, candidates, clusters, times, parts);
  hc_free(times);
  hc_free(clusters);
  hc_sample_set_link(set);
}

/* --- Crowds and holes --- */

void hc_sample_choice_thin_out(hc_sample_set *set, hc_sample_candidates *candidates, double distance) {
  const int32_t count = set->count;
  int32_t *const place = hc_alloc((size_t)count, sizeof *place); /* where samples come to */
  for (int32_t k = 0; k < set->fixed; k++) place[k] = k;
  set->count = set->fixed;
  hc_sample_set_link(set);
  for (int32_t k = set->fixed; k < count; k++) {
    const hc_sample sample = set->at[k];
    place[k] = hc_sample_set_within(set, sample.x, distance);
    if (place[k] >= 0) {
      note_change(set, sample.x);
      continue;
    }
    place[k] = set->count;
    hc_sample_set_add(set, sample.x, sample.triangle);
  }
  for (int32_t k = 0; k < candidates->count; k++) {
    int32_t *const nearest = &candidates->at[k].nearest;
    if (*nearest >= 0) *nearest = place[*nearest];
  }
  hc_free(place);
}

typedef struct gap {
  double x[3], square;
  int64_t candidate;
  int32_t triangle;
} gap;

static int by_gap(const void *left, const void *right) {
  const gap *const a = left, *const b = right;
  if (a->square != b->square) return a->square > b->square ? -1 : 1;
  return (a->candidate > b->candidate) - (a->candidate < b->candidate);
}

void hc_sample_choice_fill(hc_sample_set *set, const hc_sample_candidates *candidates, double distance,
                           const hc_parts *parts) {
  gap *gaps = hc_alloc(0, sizeof *gaps);
  size_t room = 0, count = 0;
  for (int32_t k = 0; k < candidates->count; k++) {
    const hc_sample_candidate *const c = &candidates->at[k];
    const double most = distance * distance;
    if (c->nearest >= 0 && hc_sample_set_square(set, c->nearest, c->x) <= most) continue;
    double square;
    const int32_t near = hc_sample_set_nearest(set, c->x, &square);
    if (near >= 0 && square <= most) continue;
    hc_reserve((void **)&gaps, &room, 2 * count + 1, count, sizeof *gaps);
    gaps[count++] = (gap){.x = {c->x[0], c->x[1], c->x[2]},
                          .square = near >= 0 ? square : INFINITY,
                          .candidate = candidates->first + k,
                          .triangle = c->triangle};
  }
  hc_parts_gather(parts, (void **)&gaps, &count, sizeof *gaps);
  if (count > 0) qsort(gaps, count, sizeof *gaps, by_gap);
  for (size_t k = 0; k < count; k++) {
    if (hc_sample_set_within(set, gaps[k].x, distance) >= 0) continue;
    hc_sample_set_add(set, gaps[k].x, gaps[k].triangle);
    note_change(set, gaps[k].x);
  }
  hc_free(gaps);
}
