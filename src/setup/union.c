#include "union.h"

#include "base/memory.h"
#include "setup/trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double crowding = 0.5;  /* spacings, closer is too close */
static const double rounding = 1e-4; /* spacings, by which samples may be nearer */

/* A kept sample of an earlier wall and the cubic cell, half a spacing wide, that holds it. */
typedef struct near_sample {
  int64_t cell[3], x[3];
} near_sample;

/* One wall against the earlier ones. */
typedef struct crossing {
  hc_comm *comm; /* null: alone */
  const hc_frame *frame;
  hc_setup_source *wall;
  const hc_setup_source **earlier; /* those whose surface comes near */
  int earlier_count;
  const hc_setup_source *from; /* of `earlier`: whose samples are being collected */
  double spacing;
  int64_t cell[3]; /* units */
  near_sample *near;
  size_t near_count, near_room;
  int64_t *dropped; /* samples of the wall */
  size_t dropped_count, dropped_room;
} crossing;

/* What was found among the samples of a wall, from `before` on: of a surface, by all ranks in the shares that
 * they hold, together; of other walls each has found all. */
static void share_found(const crossing *c, const hc_setup_source *of, size_t size, size_t before,
                        void **found, size_t *count, size_t *room) {
  if (!c->comm || !of->sampling.listed) return;
  void *all;
  size_t bytes;
  hc_reserve(found, room, *count + 1, *count, size);
  hc_comm_gather_all(c->comm, (char *)*found + before * size, (*count - before) * size, &all, &bytes);
  hc_reserve(found, room, before + bytes / size, before, size);
  memcpy((char *)*found + before * size, all, bytes);
  *count = before + bytes / size;
  hc_free(all);
}

/* Looks at the samples of a wall that this rank answers for. */
static void look_at(const crossing *c, const hc_setup_source *of, const hc_trace *trace) {
  const hc_sampling *const sampling = &of->sampling;
  if (sampling->listed)
    hc_trace_part(c->frame, sampling, sampling->listed_first, sampling->listed_end, trace);
  else
    hc_trace_run(c->frame, sampling, trace);
}

static int compare_cells(const void *left, const void *right) {
  const int64_t *const a = ((const near_sample *)left)->cell, *const b = ((const near_sample *)right)->cell;
  for (int k = 0; k < 3; k++)
    if (a[k] != b[k]) return a[k] < b[k] ? -1 : 1;
  return 0;
}

static int64_t divide_down(int64_t a, int64_t b) {
  return a / b - (a % b < 0);
}

static near_sample sample_at(const crossing *c, const int64_t x[3]) {
  near_sample sample;
  for (int a = 0; a < 3; a++) {
    sample.x[a] = x[a];
    sample.cell[a] = divide_down(x[a], c->cell[a]);
  }
  return sample;
}

static double distance_to(const crossing *c, const hc_setup_source *wall, const double x[3]) {
  return hc_source_layer_distance(c->frame, wall, x) - (crowding + wall->off) * c->spacing;
}

static double clearance_of_wall(const void *context, const double x[3]) {
  const crossing *const c = context;
  return distance_to(c, c->wall, x);
}

static double clearance_of_earlier(const void *context, const double x[3]) {
  const crossing *const c = context;
  double nearest = INFINITY;
  for (int e = 0; e < c->earlier_count; e++) nearest = fmin(nearest, distance_to(c, c->earlier[e], x));
  return nearest;
}

static bool collect(void *context, int64_t k, const int64_t point[3], const double x[3]) {
  (void)x;
  crossing *const c = context;
  if (hc_gaps_hold(&c->from->gaps, k)) return true;
  int64_t wrapped[3];
  for (int a = 0; a < 3; a++) wrapped[a] = hc_frame_wrap(c->frame, a, point[a]);
  hc_reserve((void **)&c->near, &c->near_room, 2 * c->near_count + 1, c->near_count, sizeof *c->near);
  c->near[c->near_count++] = sample_at(c, wrapped);
  return true;
}

static bool is_close(const crossing *c, const int64_t a[3], const int64_t b[3]) {
  double square = 0;
  for (int k = 0; k < 3; k++) {
    const double metres = (double)(a[k] - b[k]) * c->frame->unit[k];
    square += metres * metres;
  }
  const double limit = (crowding - rounding) * c->spacing;
  return square < limit * limit;
}

static bool cell_is_crowded(const crossing *c, const near_sample *sample, const int64_t cell[3]) {
  near_sample wanted;
  memcpy(wanted.cell, cell, sizeof wanted.cell);
  const near_sample *const end = c->near + c->near_count;
  const near_sample *at = bsearch(&wanted, c->near, c->near_count, sizeof *c->near, compare_cells);
  if (!at) return false;
  while (at > c->near && compare_cells(at - 1, &wanted) == 0) at--;
  for (; at < end && compare_cells(at, &wanted) == 0; at++)
    if (is_close(c, at->x, sample->x)) return true;
  return false;
}

static bool is_crowded(const crossing *c, const int64_t x[3]) {
  const near_sample sample = sample_at(c, x);
  for (int n = 0; n < 27; n++) {
    const int64_t cell[3] = {sample.cell[0] + n % 3 - 1, sample.cell[1] + n / 3 % 3 - 1,
                             sample.cell[2] + n / 9 - 1};
    if (cell_is_crowded(c, &sample, cell)) return true;
  }
  return false;
}

/* Drops the sample if it, or an image of it, is crowded. */
static bool judge(void *context, int64_t k, const int64_t point[3], const double x[3]) {
  (void)x;
  crossing *const c = context;
  const int64_t *const period = c->frame->period;
  for (int n = 0; n < 27; n++) {
    const int64_t shift[3] = {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
    int64_t image[3];
    bool needed = true;
    for (int a = 0; a < 3; a++) {
      needed &= period[a] > 0 || shift[a] == 0;
      image[a] = hc_frame_wrap(c->frame, a, point[a]) + shift[a] * period[a];
    }
    if (!needed || !is_crowded(c, image)) continue;
    hc_reserve((void **)&c->dropped, &c->dropped_room, 2 * c->dropped_count + 1, c->dropped_count, sizeof k);
    c->dropped[c->dropped_count++] = k;
    return true;
  }
  return true;
}

static bool may_meet(const crossing *c, const hc_setup_source *other) {
  if (hc_sampling_count(&other->sampling) == 0) return false;
  return distance_to(c, other, c->wall->shape.centre) <= hc_source_layer_reach(c->wall) &&
         distance_to(c, c->wall, other->shape.centre) <= hc_source_layer_reach(other);
}

/* The samples of an earlier wall that are near this one. */
static void collect_from(crossing *c, const hc_setup_source *earlier) {
  const size_t before = c->near_count;
  c->from = earlier;
  look_at(c, earlier, &(hc_trace){c, clearance_of_wall, collect});
  share_found(c, earlier, sizeof *c->near, before, (void **)&c->near, &c->near_count, &c->near_room);
}

/* Leaves out samples of this wall. */
static void drop(crossing *c) {
  c->dropped_count = 0;
  look_at(c, c->wall, &(hc_trace){c, clearance_of_earlier, judge});
  share_found(c, c->wall, sizeof *c->dropped, 0, (void **)&c->dropped, &c->dropped_count, &c->dropped_room);
  for (size_t k = 0; k < c->dropped_count; k++) hc_gaps_add(&c->wall->gaps, c->dropped[k]);
}

void hc_union_drop(hc_comm *comm, const hc_frame *frame, hc_setup_source *walls, int count) {
  crossing c = {.comm = comm,
                .frame = frame,
                .spacing = hc_trace_spacing(frame),
                .earlier = hc_alloc((size_t)count, sizeof *c.earlier)};
  for (int a = 0; a < 3; a++) c.cell[a] = (int64_t)ceil(crowding * c.spacing / frame->unit[a]);
  for (int w = 1; w < count; w++) {
    c.wall = &walls[w];
    c.earlier_count = 0;
    c.near_count = 0;
    for (int e = 0; e < w; e++)
      if (walls[e].moves == c.wall->moves && may_meet(&c, &walls[e]))
        c.earlier[c.earlier_count++] = &walls[e];
    for (int e = 0; e < c.earlier_count; e++) collect_from(&c, c.earlier[e]);
    if (c.near_count == 0) continue;
    qsort(c.near, c.near_count, sizeof *c.near, compare_cells);
    drop(&c);
  }
  hc_free(c.near);
  hc_free(c.dropped);
  hc_free((void *)c.earlier);
}
