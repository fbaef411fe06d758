#include "heights.h"

#include "base/memory.h"
#include "sph/kernel.h"

#include <stdlib.h>

static const double GAP = 1.5;  /* spacings between particles that are one run */
static const double END = 0.49; /* of the largest sum: a lattice's flat surface has 0.498 */
enum { HALVINGS = 30 };         /* of half a spacing, where a run ends */

void hc_heights_mark(const hc_gauges *gauges, int g, const hc_particles *fluid, hc_marks *marks) {
  const double reach = gauges->frame->support_radius, *const d = gauges->state[g].direction;
  const hc_point at = hc_measure_point(gauges->frame, gauges->state[g].at);
  for (int32_t i = 0; i < fluid->own; i++) {
    double offset[3], square = 0.0;
    hc_measure_offset(gauges->frame, &fluid->position[3 * (size_t)i], &at, offset);
    const double along = offset[0] * d[0] + offset[1] * d[1] + offset[2] * d[2];
    for (int a = 0; a < 3; a++) square += (offset[a] - along * d[a]) * (offset[a] - along * d[a]);
    if (square > reach * reach) continue;
    hc_reserve((void **)&marks->at, &marks->room, marks->count + 1, marks->count, sizeof *marks->at);
    marks->at[marks->count++] = (hc_mark){g, along, sqrt(square)};
  }
}

static int compare(double a, double b) {
  return (a > b) - (a < b);
}

static int ascending(const void *a, const void *b) {
  const hc_mark *const p = a, *const q = b;
  if (p->gauge != q->gauge) return p->gauge < q->gauge ? -1 : 1;
  const int order = compare(p->along, q->along);
  return order != 0 ? order : compare(p->beside, q->beside);
}

void hc_heights_gather(hc_comm *comm, hc_marks *marks) {
  void *all;
  size_t bytes;
  hc_comm_gather_all(comm, marks->at, marks->count * sizeof *marks->at, &all, &bytes);
  hc_free(marks->at);
  marks->at = all;
  marks->count = marks->room = bytes / sizeof *marks->at;
  if (marks->count) qsort(marks->at, marks->count, sizeof *marks->at, ascending);
}

/* The marks of one gauge. */
typedef struct line {
  const hc_mark *at;
  size_t count;
  double spacing, reach; /* m; reach: the support radius */
} line;

/* The kernel's sum at a point of the line, without its constant. */
static double sum_at(const line *line, double along) {
  size_t low = 0, high = line->count;
  while (low < high) {
    const size_t middle = low + (high - low) / 2;
    if (line->at[middle].along < along - line->reach)
      low = middle + 1;
    else
      high = middle;
  }
  double sum = 0.0;
  for (size_t k = low; k < line->count && line->at[k].along <= along + line->reach; k++) {
    const double before = line->at[k].along - along, beside = line->at[k].beside;
    sum += hc_kernel_shape(sqrt(before * before + beside * beside) / line->reach);
  }
  return sum;
}

/* Where the sum falls to `end` on the way from a particle that has more to half a spacing beyond the last. */
static double end_of(const line *line, double inner, double outer, double end) {
  if (sum_at(line, outer) >= end) return outer;
  for (int k = 0; k < HALVINGS; k++) {
    const double middle = 0.5 * (inner + outer);
    if (sum_at(line, middle) >= end)
      inner = middle;
    else
      outer = middle;
  }
  return 0.5 * (inner + outer);
}

/* A particle within a spacing of the line, and the kernel's sum there. */
typedef struct wet_place {
  double along, sum;
} wet_place;

static double length_of(const line *line, const wet_place *run, size_t count) {
  const double half_spacing = 0.5 * line->spacing;
  double most = 0.0;
  for (size_t k = 0; k < count; k++) most = fmax(most, run[k].sum);
  size_t first = 0, last = count - 1;
  while (run[first].sum < END * most) first++;
  while (run[last].sum < END * most) last--;
  return end_of(line, run[last].along, run[count - 1].along + half_spacing, END * most) -
         end_of(line, run[first].along, run[0].along - half_spacing, END * most);
}

double hc_heights_wet(const hc_gauges *gauges, int g, const hc_marks *marks) {
  line line = {.spacing = gauges->scene->particle_spacing, .reach = gauges->frame->support_radius};
  for (size_t k = 0; k < marks->count; k++) {
    if (marks->at[k].gauge != g) continue;
    if (line.count++ == 0) line.at = &marks->at[k];
  }
  wet_place *const places = hc_alloc(line.count, sizeof *places);
  size_t count = 0, begin = 0;
  double wet = 0.0;
  for (size_t k = 0; k < line.count; k++) {
    const hc_mark *const mark = &line.at[k];
    if (mark->beside > line.spacing) continue;
    if (count > begin && mark->along - places[count - 1].along > GAP * line.spacing) {
      wet += length_of(&line, &places[begin], count - begin);
      begin = count;
    }
    places[count++] = (wet_place){mark->along, sum_at(&line, mark->along)};
  }
  if (count > begin) wet += length_of(&line, &places[begin], count - begin);
  hc_free(places);
  return wet;
}
