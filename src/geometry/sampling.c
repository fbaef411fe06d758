#include "sampling.h"

#include "base/check.h"
#include "base/memory.h"
#include "base/turns.h"
#include "surface.h"

#include <math.h>

/* More along an axis is refused, which keeps every product below in 64 bits. */
#define MAX_CELLS ((int64_t)1 << 30)
#define MAX_POINTS ((int64_t)1 << 62)

/* Lengths are decimal fractions and the spacing is rounded to units: a multiple is one to this part of the
 * length. */
static const double length_tolerance = 1e-6;

/* Indices along an axis that belong together: a face's row, or what is between the faces. */
typedef struct segment {
  int64_t start, count;
  bool face; /* a row of a closed face */
} segment;

static double slack(double ratio) {
  return fmin(length_tolerance * (1 + ratio), 0.25);
}

double hc_sampling_whole(double ratio) {
  return floor(ratio + slack(ratio));
}

static double spacings(const hc_lattice *lattice, int axis, double length) {
  return length / ((double)lattice->spacing[axis] * lattice->unit[axis]);
}

static int64_t to_cells(double count) {
  if (!(count > 0)) return 0;
  return count < (double)MAX_CELLS ? (int64_t)count : MAX_CELLS;
}

static int64_t nearest_cells(double ratio) {
  const int64_t cells = to_cells(rint(ratio));
  return cells > 0 ? cells : 1;
}

static int64_t to_units(const hc_lattice *lattice, int axis, double metres) {
  return lattice->origin[axis] + llrint(metres / lattice->unit[axis]);
}

/* A length in units: exactly `cells` spacings if it is that many. */
static int64_t length_units(const hc_lattice *lattice, int axis, double length, int64_t cells) {
  const double ratio = spacings(lattice, axis, length);
  if (fabs(ratio - (double)cells) <= slack(ratio)) return cells * lattice->spacing[axis];
  return llrint(length / lattice->unit[axis]);
}

/* Cell centres of a row of `cells` cells from `low` on, and half a spacing beyond its ends. */
static hc_sampling_axis centred_axis(int64_t low, int64_t length, int64_t cells, int64_t spacing) {
  const int64_t half = (length + cells) / (2 * cells);
  const int64_t steps = cells - 1;
  return (hc_sampling_axis){.first = low + (steps > 0 ? half : length / 2),
                            .span = steps > 0 ? length - 2 * half : 0,
                            .steps = steps,
                            .below = low - spacing / 2,
                            .above = low + length + spacing / 2,
                            .pitch = spacing};
}

static int64_t axis_position(const hc_sampling_axis *axis, int64_t index) {
  if (index < 0) return axis->below + (index + 1) * axis->pitch;
  if (index > axis->steps) return axis->above + (index - axis->steps - 1) * axis->pitch;
  if (axis->steps == 0) return axis->first;
  const int64_t whole = axis->span / axis->steps, rest = axis->span % axis->steps;
  return axis->first + index * whole + (rest ? (2 * index * rest + axis->steps) / (2 * axis->steps) : 0);
}

static void add_part(hc_sampling *sampling, const int64_t start[3], const int64_t count[3]) {
  if (count[0] == 0 || count[1] == 0 || count[2] == 0 || sampling->count == INT64_MAX) return;
  HC_CHECK(sampling->part_count < HC_SAMPLING_MAX_PARTS, "a sampling has at most %d parts",
           HC_SAMPLING_MAX_PARTS);
  hc_sampling_part *const part = &sampling->parts[sampling->part_count++];
  int64_t points = 1;
  bool too_many = false;
  for (int a = 0; a < 3; a++) {
    part->start[a] = start[a];
    part->count[a] = count[a];
    too_many |= count[a] >= MAX_CELLS || __builtin_mul_overflow(points, count[a], &points);
  }
  part->first = sampling->count;
  too_many |= __builtin_add_overflow(sampling->count, points, &sampling->count);
  if (too_many || sampling->count > MAX_POINTS) sampling->count = INT64_MAX;
}

hc_sampling hc_sampling_block(const hc_lattice *lattice, const double min[3], const double max[3]) {
  hc_sampling sampling = {0};
  int64_t cells[3];
  for (int a = 0; a < 3; a++) {
    const double ratio = spacings(lattice, a, max[a] - min[a]);
    cells[a] = to_cells(ratio > 0 ? hc_sampling_whole(ratio) : 0);
    const int64_t spacing = lattice->spacing[a];
    if (cells[a] > 0)
      sampling.axis[a] = centred_axis(to_units(lattice, a, min[a]), cells[a] * spacing, cells[a], spacing);
  }
  add_part(&sampling, (const int64_t[3]){0, 0, 0}, cells);
  return sampling;
}

/* All products of segments, one along each axis, that lie on a closed face. Those behind faces across axis 0
 * row by row: points of long rows follow each other, see hc_sampling_row_end. */
static void add_shell(hc_sampling *sampling, segment segments[3][3], const int segment_count[3]) {
  for (int k = 0; k < segment_count[2]; k++)
    for (int j = 0; j < segment_count[1]; j++)
      for (int i = 0; i < segment_count[0]; i++) {
        const segment *const x = &segments[0][i], *const y = &segments[1][j], *const z = &segments[2][k];
        if (!x->face && !y->face && !z->face) continue;
        const int64_t at_once = x->face ? 1 : x->count;
        for (int64_t row = 0; row < x->count; row += at_once)
          add_part(sampling, (const int64_t[3]){x->start + row, y->start, z->start},
                   (const int64_t[3]){at_once, y->count, z->count});
      }
}

static bool is_open(unsigned open, int axis, int upper) {
  return open >> (2 * axis + upper) & 1;
}

hc_sampling hc_sampling_container(const hc_lattice *lattice, const double min[3], const double max[3],
                                  unsigned open, int layers) {
  hc_sampling sampling = {0};
  segment segments[3][3];
  int segment_count[3] = {0, 0, 0};
  for (int a = 0; a < 3; a++) {
    const int64_t cells = nearest_cells(spacings(lattice, a, max[a] - min[a]));
    sampling.axis[a] =
        centred_axis(to_units(lattice, a, min[a]), length_units(lattice, a, max[a] - min[a], cells), cells,
                     lattice->spacing[a]);
    if (!is_open(open, a, 0)) segments[a][segment_count[a]++] = (segment){-layers, layers, true};
    segments[a][segment_count[a]++] = (segment){0, cells, false};
    if (!is_open(open, a, 1)) segments[a][segment_count[a]++] = (segment){cells, layers, true};
  }
  add_shell(&sampling, segments, segment_count);
  return sampling;
}

/* Rows from half a spacing inside one face to half a spacing inside the other, or one in the middle. */
static hc_sampling_axis solid_axis(int64_t low, int64_t length, int64_t rows, int64_t spacing) {
  if (rows == 1) return (hc_sampling_axis){.first = low + length / 2};
  return (hc_sampling_axis){.first = low + spacing / 2, .span = length - spacing, .steps = rows - 1};
}

int hc_sampling_layers_within(double thickness, int layers) {
  return hc_sampling_whole(thickness) >= 3 ? layers : 1;
}

hc_sampling hc_sampling_solid(const hc_lattice *lattice, const double min[3], const double max[3],
                              unsigned open, int layers) {
  hc_sampling sampling = {0};
  segment segments[3][3];
  int segment_count[3] = {0, 0, 0};
  for (int a = 0; a < 3; a++) {
    const double thickness = spacings(lattice, a, max[a] - min[a]);
    const int64_t rows = nearest_cells(thickness);
    sampling.axis[a] = solid_axis(to_units(lattice, a, min[a]),
                                  length_units(lattice, a, max[a] - min[a], rows), rows, lattice->spacing[a]);
    const bool lower = !is_open(open, a, 0), upper = !is_open(open, a, 1);
    const int64_t within = hc_sampling_layers_within(thickness, layers);
    const int64_t outer = within < rows / 2 ? within : rows / 2, middle = rows - 2 * outer;
    if (outer > 0) segments[a][segment_count[a]++] = (segment){0, outer, lower};
    if (middle > 0)
      segments[a][segment_count[a]++] = (segment){outer, middle, within > outer && (lower || upper)};
    if (outer > 0) segments[a][segment_count[a]++] = (segment){rows - outer, outer, upper};
  }
  add_shell(&sampling, segments, segment_count);
  return sampling;
}

hc_sampling hc_sampling_plane(const hc_lattice *lattice, const double point[3], const double normal[3],
                              const double size[2], int layers) {
  const hc_shape shape = hc_shape_rectangle(point, normal, size);
  int axis = 0;
  while (axis < 2 && fabs(shape.axes[2][axis]) < 1) axis++;
  if (fabs(shape.axes[2][axis]) < 1) {
    static const double middle[3] = {0, 0, 0}, up[3] = {0, 0, 1};
    const hc_lattice own = hc_sampling_own_lattice(lattice);
    hc_sampling turned = hc_sampling_plane(&own, middle, up, size, layers);
    hc_sampling_turn(&turned, lattice, &shape);
    return turned;
  }
  const int along[2] = {(axis + 1) % 3, (axis + 2) % 3};
  hc_sampling sampling = {0};
  int64_t cells[3];
  for (int t = 0; t < 2; t++) {
    const int a = along[t];
    cells[a] = nearest_cells(spacings(lattice, a, size[t]));
    const int64_t low = to_units(lattice, a, point[a] - 0.5 * size[t]);
    sampling.axis[a] =
        centred_axis(low, length_units(lattice, a, size[t], cells[a]), cells[a], lattice->spacing[a]);
  }
  const int64_t behind = lattice->spacing[axis] / 2;
  cells[axis] = 1;
  sampling.axis[axis].first = to_units(lattice, axis, point[axis]) + (normal[axis] > 0 ? -behind : behind);
  sampling.axis[axis].above = sampling.axis[axis].first + 2 * (normal[axis] > 0 ? -behind : behind);
  for (int layer = 0; layer < layers; layer++) {
    int64_t start[3] = {0, 0, 0};
    start[axis] = layer;
    add_part(&sampling, start, cells);
  }
  return sampling;
}

hc_lattice hc_sampling_own_lattice(const hc_lattice *lattice) {
  hc_lattice own = {0};
  for (int a = 0; a < 3; a++) {
    own.unit[a] = lattice->unit[0];
    own.spacing[a] = lattice->spacing[0];
  }
  return own;
}

void hc_sampling_turn(hc_sampling *sampling, const hc_lattice *lattice, const hc_shape *shape) {
  sampling->turned = true;
  for (int a = 0; a < 3; a++) {
    sampling->centre[a] = to_units(lattice, a, shape->centre[a]);
    for (int t = 0; t < 3; t++)
      sampling->turn[a][t] = shape->axes[t][a] * lattice->unit[0] / lattice->unit[a];
  }
}

void hc_sampling_add_run(hc_sampling *sampling, const hc_sampling_run *run) {
  if (run->count <= 0 || run->repeat <= 0 || sampling->count == INT64_MAX) return;
  hc_reserve((void **)&sampling->runs, &sampling->run_room, 2 * (size_t)sampling->run_count + 1,
             (size_t)sampling->run_count, sizeof *run);
  hc_sampling_run *const added = &sampling->runs[sampling->run_count++];
  *added = *run;
  added->first = sampling->count;
  int64_t points = 0;
  const bool too_many = run->count >= MAX_CELLS || run->repeat >= MAX_CELLS ||
                        __builtin_mul_overflow(run->count, run->repeat, &points) ||
                        __builtin_add_overflow(sampling->count, points, &sampling->count);
  if (too_many || sampling->count > MAX_POINTS) sampling->count = INT64_MAX;
}

void hc_sampling_free(hc_sampling *sampling) {
  hc_free(sampling->runs);
  *sampling = (hc_sampling){0};
}

int64_t hc_sampling_count(const hc_sampling *sampling) {
  return sampling->count;
}

/* From own axes to the frame's. */
static void turn_into_place(const hc_sampling *sampling, const double own[3], int64_t x[3]) {
  for (int a = 0; a < 3; a++) {
    const double *const turn = sampling->turn[a];
    x[a] = sampling->centre[a] + llrint(turn[0] * own[0] + turn[1] * own[1] + turn[2] * own[2]);
  }
}

static void part_position(const hc_sampling *sampling, const int64_t index[3], int64_t x[3]) {
  for (int a = 0; a < 3; a++) x[a] = axis_position(&sampling->axis[a], index[a]);
  if (!sampling->turned) return;
  const double own[3] = {(double)x[0], (double)x[1], (double)x[2]};
  turn_into_place(sampling, own, x);
}

static void run_position(const hc_sampling *sampling, const hc_sampling_run *run, int64_t index,
                         int64_t repetition, int64_t x[3]) {
  double own[3] = {run->at[0], run->at[1], run->at[2] + (double)repetition * run->rise};
  if (sampling->rings) {
    const double turns = (double)index / (double)run->count;
    own[0] = run->at[0] * hc_turns_cosine(turns);
    own[1] = run->at[0] * hc_turns_sine(turns);
  } else {
    own[0] += (double)index * sampling->pitch;
  }
  turn_into_place(sampling, own, x);
}

static void check_point(const hc_sampling *sampling, int64_t k) {
  HC_CHECK(k >= 0 && k < sampling->count && sampling->count < INT64_MAX,
           "sample must lie in [0, %lld), got %lld", (long long)sampling->count, (long long)k);
}

static const hc_sampling_part *part_of(const hc_sampling *sampling, int64_t k) {
  int p = sampling->part_count - 1;
  while (sampling->parts[p].first > k) p--;
  return &sampling->parts[p];
}

static const hc_sampling_run *run_of(const hc_sampling *sampling, int64_t k) {
  int64_t low = 0, high = sampling->run_count; /* runs[low].first <= k, and not so from `high` on */
  while (high - low > 1) {
    const int64_t middle = low + (high - low) / 2;
    *(sampling->runs[middle].first <= k ? &low : &high) = middle;
  }
  return &sampling->runs[low];
}

/* ---- tilings ---- */

/* From parts of a spacing to units. */
static int64_t tile_units(int64_t parts, int64_t spacing) {
  return llrint((double)parts / HC_TILE_UNIT * (double)spacing);
}

static int64_t divide_down(int64_t a, int64_t b) {
  return a / b - (a % b < 0);
}

hc_sampling hc_sampling_tiled(const hc_lattice *lattice, const hc_sampling_tile *tile, const double origin[3],
                              const double min[3], const double max[3]) {
  hc_sampling sampling = {.count = tile->count, .tile = *tile};
  for (int a = 0; a < 3; a++) {
    const int64_t start = to_units(lattice, a, origin[a]),
                  step = tile_units(tile->extent[a], lattice->spacing[a]);
    sampling.tile_spacing[a] = lattice->spacing[a];
    sampling.tile_step[a] = step;
    sampling.tile_low[a] = to_units(lattice, a, min[a]);
    sampling.tile_high[a] = to_units(lattice, a, max[a]);
    const int64_t first = divide_down(sampling.tile_low[a] - start, step),
                  last = divide_down(sampling.tile_high[a] - 1 - start, step);
    sampling.tile_first[a] = start + first * step;
    sampling.images[a] = last - first + 1 > 0 ? last - first + 1 : 0;
    sampling.count = sampling.count > MAX_POINTS / (sampling.images[a] + 1)
                         ? MAX_POINTS
                         : sampling.count * sampling.images[a];
  }
  if (sampling.count >= MAX_POINTS) sampling.count = INT64_MAX;
  return sampling;
}

/* The lower corner of the image that holds point k. */
static void image_corner(const hc_sampling *sampling, int64_t k, int64_t corner[3]) {
  int64_t image = k / sampling->tile.count;
  for (int a = 0; a < 3; a++) {
    corner[a] = sampling->tile_first[a] + image % sampling->images[a] * sampling->tile_step[a];
    image /= sampling->images[a];
  }
}

void hc_sampling_image(const hc_sampling *sampling, int64_t k, double middle[3], int64_t *end) {
  int64_t corner[3];
  check_point(sampling, k);
  image_corner(sampling, k, corner);
  for (int a = 0; a < 3; a++) middle[a] = (double)corner[a] + 0.5 * (double)sampling->tile_step[a];
  *end = (k / sampling->tile.count + 1) * sampling->tile.count;
}

void hc_sampling_point(const hc_sampling *sampling, int64_t k, int64_t x[3]) {
  check_point(sampling, k);
  if (sampling->tile.at) {
    const int32_t *const at = sampling->tile.at[k % sampling->tile.count];
    image_corner(sampling, k, x);
    for (int a = 0; a < 3; a++) x[a] += tile_units(at[a], sampling->tile_spacing[a]);
    return;
  }
  if (sampling->listed) {
    HC_CHECK(k >= sampling->listed_first && k < sampling->listed_end,
             "samples %lld to %lld are held here, got %lld", (long long)sampling->listed_first,
             (long long)sampling->listed_end - 1, (long long)k);
    turn_into_place(sampling, sampling->listed[k - sampling->listed_first].x, x);
    return;
  }
  if (sampling->run_count > 0) {
    const hc_sampling_run *const run = run_of(sampling, k);
    const int64_t in_run = k - run->first;
    run_position(sampling, run, in_run % run->count, in_run / run->count, x);
    return;
  }
  const hc_sampling_part *const part = part_of(sampling, k);
  const int64_t in_part = k - part->first;
  const int64_t row = in_part / part->count[0];
  const int64_t index[3] = {part->start[0] + in_part % part->count[0], part->start[1] + row % part->count[1],
                            part->start[2] + row / part->count[1]};
  part_position(sampling, index, x);
}

int64_t hc_sampling_row_end(const hc_sampling *sampling, int64_t k) {
  check_point(sampling, k);
  int64_t first, length;
  if (sampling->listed || sampling->tile.at) return k + 1;
  if (sampling->run_count > 0) {
    const hc_sampling_run *const run = run_of(sampling, k);
    first = run->first;
    length = run->count > 1 ? run->count : run->repeat;
  } else {
    const hc_sampling_part *const part = part_of(sampling, k);
    int a = 0;
    while (a < 2 && part->count[a] == 1) a++;
    first = part->first;
    length = part->count[a];
  }
  return k + length - (k - first) % length;
}

static void widen(const int64_t x[3], int64_t low[3], int64_t high[3]) {
  for (int a = 0; a < 3; a++) {
    if (x[a] < low[a]) low[a] = x[a];
    if (x[a] > high[a]) high[a] = x[a];
  }
}

static void run_bounds(const hc_sampling *sampling, const hc_sampling_run *run, int64_t low[3],
                       int64_t high[3]) {
  for (int end = 0; end < 4; end++) {
    const int64_t repetition = end & 2 ? run->repeat - 1 : 0;
    int64_t x[3];
    if (!sampling->rings) {
      run_position(sampling, run, end & 1 ? run->count - 1 : 0, repetition, x);
      widen(x, low, high);
      continue;
    }
    /* The circle, and a unit for what its points are rounded by. */
    const double middle[3] = {0, 0, run->at[2] + (double)repetition * run->rise};
    turn_into_place(sampling, middle, x);
    for (int a = 0; a < 3; a++) {
      const double *const turn = sampling->turn[a];
      const int64_t reach = llrint(run->at[0] * sqrt(turn[0] * turn[0] + turn[1] * turn[1])) + 1;
      if (x[a] - reach < low[a]) low[a] = x[a] - reach;
      if (x[a] + reach > high[a]) high[a] = x[a] + reach;
    }
  }
}

void hc_sampling_bounds(const hc_sampling *sampling, int64_t low[3], int64_t high[3]) {
  HC_CHECK(sampling->count > 0 && sampling->count < INT64_MAX, "bounds need points, got %lld",
           (long long)sampling->count);
  for (int a = 0; a < 3; a++) {
    low[a] = INT64_MAX;
    high[a] = INT64_MIN;
  }
  for (int a = 0; a < 3 && sampling->tile.at; a++) {
    low[a] = sampling->tile_low[a];
    high[a] = sampling->tile_high[a];
  }
  for (int end = 0; end < 2 && sampling->listed; end++) { /* not turned: no axis changes its order */
    int64_t x[3];
    turn_into_place(sampling, end ? sampling->listed_high : sampling->listed_low, x);
    widen(x, low, high);
  }
  for (int64_t r = 0; r < sampling->run_count; r++) run_bounds(sampling, &sampling->runs[r], low, high);
  /* Positions are monotonic in each index, so the corners of the parts are enough. */
  for (int p = 0; p < sampling->part_count; p++)
    for (int corner = 0; corner < 8; corner++) {
      const hc_sampling_part *const part = &sampling->parts[p];
      int64_t index[3], x[3];
      for (int a = 0; a < 3; a++) index[a] = part->start[a] + (corner >> a & 1 ? part->count[a] - 1 : 0);
      part_position(sampling, index, x);
      widen(x, low, high);
    }
}
