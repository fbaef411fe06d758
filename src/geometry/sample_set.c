#include "sample_set.h"

#include "base/memory.h"

static const double wide = 1.4; /* reaches: the edge of a cell, and how far neighbours are looked for */

hc_sample_set hc_sample_set_make(double reach) {
  return (hc_sample_set){.reach = reach, .edge = wide * reach};
}

void hc_sample_set_free(hc_sample_set *set) {
  hc_free(set->at);
  hc_free(set->heads);
  hc_free(set->changed);
  *set = (hc_sample_set){0};
}

/* --- The grid --- */

static int64_t floor_of(double x) {
  const int64_t whole = (int64_t)x;
  return whole - (x < (double)whole);
}

static void cell_of(const hc_sample_set *set, const double x[3], int64_t cell[3]) {
  for (int a = 0; a < 3; a++) cell[a] = floor_of(x[a] / set->edge);
}

/* A cell's hash is made of the sum of its axes' parts. */
static uint64_t part_of(int axis, int64_t cell) {
  static const uint64_t factors[3] = {0x9e3779b97f4a7c15u, 0xbf58476d1ce4e5b9u, 0x94d049bb133111ebu};
  return (uint64_t)cell * factors[axis];
}

static int32_t *head_of(const hc_sample_set *set, uint64_t bits) {
  return &set->heads[(bits ^ bits >> 32) * 0xd1342543de82ef95u >> 33 & (uint64_t)(set->head_count - 1)];
}

static void link_sample(hc_sample_set *set, int32_t k) {
  int64_t cell[3];
  cell_of(set, set->at[k].x, cell);
  int32_t *const head = head_of(set, part_of(0, cell[0]) + part_of(1, cell[1]) + part_of(2, cell[2]));
  set->at[k].next = *head;
  *head = k;
}

void hc_sample_set_link(hc_sample_set *set) {
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

void hc_sample_set_add(hc_sample_set *set, const double x[3], int32_t triangle) {
  const size_t count = (size_t)set->count;
  hc_reserve((void **)&set->at, &set->room, 2 * count + 1, count, sizeof *set->at);
  set->at[set->count++] = (hc_sample){{x[0], x[1], x[2]}, triangle, -1};
  if (set->count > set->head_count / 2)
    hc_sample_set_link(set);
  else
    link_sample(set, set->count - 1);
}

/* What is around a point: cells, its own first, and squares of how far off they are at least. */
typedef struct around {
  uint64_t part[3][3]; /* of the hashes of the cell before, its own and the one behind, along each axis */
  double beyond[3][3]; /* the same for the squares */
} around;

static around look_around(const hc_sample_set *set, const double x[3]) {
  around here;
  int64_t middle[3];
  cell_of(set, x, middle);
  for (int a = 0; a < 3; a++) {
    const double within = x[a] - (double)middle[a] * set->edge, left = set->edge - within;
    for (int k = 0; k < 3; k++) here.part[a][k] = part_of(a, middle[a] + k - 1);
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
  return *head_of(set, here->part[0][i] + here->part[1][j] + here->part[2][k]);
}

int32_t hc_sample_set_nearest(const hc_sample_set *set, const double x[3], double *square) {
  int32_t found = -1;
  *square = set->reach * set->reach;
  if (set->count == 0) return -1;
  const around here = look_around(set, x);
  for (int n = 0; n < 27; n++)
    for (int32_t s = first_of(set, &here, n, *square); s >= 0; s = set->at[s].next) {
      const double away = hc_sample_set_square(set, s, x);
      if (away > *square || (away == *square && (found < 0 || s >= found))) continue;
      *square = away;
      found = s;
    }
  return found;
}

int32_t hc_sample_set_within(const hc_sample_set *set, const double x[3], double distance) {
  const double square = distance * distance;
  if (set->count == 0) return -1;
  const around here = look_around(set, x);
  for (int n = 0; n < 27; n++)
    for (int32_t s = first_of(set, &here, n, square); s >= 0; s = set->at[s].next)
      if (hc_sample_set_square(set, s, x) < square) return s;
  return -1;
}
/* --- Neighbours among samples --- */

hc_sample_neighbors hc_sample_neighbors_make(const hc_sample_set *set) {
  hc_sample_neighbors n = {.of = hc_alloc((size_t)set->count, sizeof *n.of), .most = set->edge * set->edge};
  for (int32_t s = 0; s < set->count; s++) n.of[s].first = -1;
  return n;
}

void hc_sample_neighbors_free(hc_sample_neighbors *n) {
  hc_free(n->of);
  hc_free(n->with);
}

static const hc_sample_near *neighbors_of(const hc_sample_set *set, hc_sample_neighbors *n, int32_t s) {
  hc_sample_near *const found = &n->of[s];
  if (found->first >= 0) return found;
  const double *const x = set->at[s].x;
  const around here = look_around(set, x);
  *found = (hc_sample_near){n->most, n->end, 0};
  for (int cell = 0; cell < 27; cell++)
    for (int32_t other = first_of(set, &here, cell, n->most); other >= 0; other = set->at[other].next) {
      const double square = hc_sample_set_square(set, other, x);
      if (square >= n->most || other == s) continue;
      hc_reserve((void **)&n->with, &n->room, 2 * (size_t)n->end + 1, (size_t)n->end, sizeof *n->with);
      n->with[n->end++] = other;
      found->count++;
      if (square < found->nearest) found->nearest = square;
    }
  return found;
}

int32_t hc_sample_neighbors_nearest(const hc_sample_set *set, hc_sample_neighbors *n, const double x[3],
                                    int32_t guess) {
  double square;
  if (guess < 0) return hc_sample_set_nearest(set, x, &square);
  square = hc_sample_set_square(set, guess, x);
  for (;;) {
    const hc_sample_near *const around = neighbors_of(set, n, guess);
    if (4 * square * (1 + 1e-9) < around->nearest) break;
    int32_t next = guess;
    for (int32_t k = around->first; k < around->first + around->count; k++) {
      const int32_t other = n->with[k];
      const double away = hc_sample_set_square(set, other, x);
      if (away > square || (away == square && other >= next)) continue;
      square = away;
      next = other;
    }
    if (next == guess) {
      if (4 * square * (1 + 1e-9) < n->most) break;
      return hc_sample_set_nearest(set, x, &square);
    }
    guess = next;
  }
  return square < set->reach * set->reach ? guess : -1;
}
