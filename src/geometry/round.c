#include "round.h"

#include "base/turns.h"

#include <math.h>

static const double pi = 3.14159265358979323846;
static const double most_runs = 1 << 24; /* more is refused, for they are stored */

/* As a number of points or repetitions, of which a sampling refuses too many. */
static int64_t to_count(double count) {
  return (int64_t)fmin(count, 1e18);
}

/* A shape being sampled: lengths in units of axis 0. */
typedef struct work {
  const hc_shape *shape;
  double unit, spacing;
  hc_sampling sampling;
} work;

static work begin(const hc_lattice *lattice, const hc_shape *shape) {
  return (work){.shape = shape,
                .unit = lattice->unit[0],
                .spacing = (double)lattice->spacing[0],
                .sampling = {.pitch = (double)lattice->spacing[0]}};
}

static double nearest(double ratio) {
  return fmax(1, rint(ratio));
}

/* True, and the sampling marked so, if it would need too many runs. */
static bool too_many(work *w, double runs) {
  if (runs <= most_runs) return false;
  w->sampling.count = INT64_MAX;
  return true;
}

static hc_sampling fill_round(work w) {
  const hc_shape *const shape = w.shape;
  const double radius = shape->high[0] / w.unit / w.spacing - 0.5; /* of the outermost points, in spacings */
  const double reach = hc_sampling_whole(radius);
  if (reach < 0) return w.sampling;
  const double most = fmax(reach * reach, radius * radius) * (1 + 2e-6); /* decimal fractions */
  const bool sphere = shape->round == 3;
  if (too_many(&w, (2 * reach + 1) * (sphere ? 2 * reach + 1 : 1))) return w.sampling;
  const double length = shape->high[1] / w.unit - shape->low[1] / w.unit;
  const double layers = hc_sampling_whole(length / w.spacing);
  if (!sphere && layers < 1) return w.sampling;
  for (double k = sphere ? -reach : 0; k <= (sphere ? reach : 0); k++)
    for (double j = -reach; j <= reach; j++) {
      const double left = most - k * k - j * j;
      if (left < 0) continue;
      const double i = floor(sqrt(left));
      const double height = sphere ? k * w.spacing : 0.5 * (w.spacing - length);
      const hc_sampling_run row = {.at = {-i * w.spacing, j * w.spacing, height},
                                   .rise = w.spacing,
                                   .count = to_count(2 * i + 1),
                                   .repeat = sphere ? 1 : to_count(layers)};
      hc_sampling_add_run(&w.sampling, &row);
    }
  return w.sampling;
}

static void add_rings(work *w, double radius, double height, double rise, double repeat) {
  const double count = nearest(2 * pi * radius / w->spacing);
  const hc_sampling_run ring = {
      .at = {radius, 0, height}, .rise = rise, .count = to_count(count), .repeat = to_count(repeat)};
  hc_sampling_add_run(&w->sampling, &ring);
}

/* Rings about the middle of a disc: `count` of the `steps` + 1 up to `radius`. */
static void add_disc(work *w, double radius, double height, double steps, double count) {
  for (double j = 0; j < count; j++) add_rings(w, steps > 0 ? radius * j / steps : radius, height, 0, 1);
}

/* Around a cylinder of fluid: the layers go around the rim. */
static void add_container(work *w, double length, double rows, int layers) {
  const double radius = w->shape->high[0] / w->unit, low = w->shape->low[1] / w->unit,
               high = w->shape->high[1] / w->unit;
  const double first = radius + 0.5 * w->spacing, steps = rint(first / w->spacing);
  if (too_many(w, steps)) return;
  for (int side = 0; side < layers; side++)
    add_rings(w, first + side * w->spacing, 0.5 * (length / rows - length), length / rows, rows);
  for (int end = 0; end < 2; end++)
    for (int layer = 0; layer < layers && !(w->shape->open >> (2 + end) & 1); layer++) {
      const double behind = (0.5 + layer) * w->spacing, height = end ? high + behind : low - behind;
      add_disc(w, first, height, steps, steps);
      for (int side = 0; side < layers; side++) add_rings(w, first + side * w->spacing, height, 0, 1);
    }
}

/* Within a cylinder: of all its rings and rows the outer ones. */
static void add_solid(work *w, const hc_shape *layer, double length, double rows, int layers) {
  const double radius = layer->high[0] / w->unit, low = layer->low[1] / w->unit,
               high = layer->high[1] / w->unit;
  const double steps = rint(radius / w->spacing), pitch = rows > 1 ? (high - low) / (rows - 1) : 0;
  if (too_many(w, steps)) return;
  const double across = 2 * w->shape->high[0] / w->unit / w->spacing;
  const double sides = fmin(hc_sampling_layers_within(across, layers), steps + 1);
  const double ends = hc_sampling_layers_within(length / w->spacing, layers);
  const double bottom = w->shape->open & 4 ? 0 : fmin(ends, rows),
               top = w->shape->open & 8 ? 0 : fmin(ends, rows - bottom);
  add_rings(w, radius, low, pitch, rows);
  for (double side = 1; side < sides; side++)
    add_rings(w, radius * (steps - side) / steps, low + bottom * pitch, pitch, rows - bottom - top);
  for (double row = 0; row < bottom; row++) add_disc(w, radius, low + row * pitch, steps, steps);
  for (double row = 0; row < top; row++) add_disc(w, radius, high - row * pitch, steps, steps);
}

static void add_sphere(work *w, const hc_shape *layer) {
  const double radius = layer->high[0] / w->unit;
  const double steps = radius > 0 ? nearest(pi * radius / w->spacing) : 0;
  if (too_many(w, steps)) return;
  for (double j = 0; j <= steps; j++) {
    const double turns = steps > 0 ? 0.5 * j / steps : 0;
    add_rings(w, radius * fabs(hc_turns_sine(turns)), radius * hc_turns_cosine(turns), 0, 1);
  }
}

static hc_sampling wall_round(work w, bool solid, int layers) {
  const double spacing = w.spacing * w.unit, across = 2 * w.shape->high[0] / spacing;
  w.sampling.rings = true;
  if (w.shape->round == 2) {
    const double length = (w.shape->high[1] - w.shape->low[1]) / w.unit, rows = nearest(length / w.spacing);
    const hc_shape layer = hc_shape_layer(w.shape, spacing, solid, 0);
    if (solid)
      add_solid(&w, &layer, length, rows, layers);
    else
      add_container(&w, length, rows, layers);
    return w.sampling;
  }
  if (solid) layers = hc_sampling_layers_within(across, layers);
  for (int l = 0; l < layers; l++) {
    const hc_shape layer = hc_shape_layer(w.shape, spacing, solid, l);
    add_sphere(&w, &layer);
  }
  return w.sampling;
}

hc_sampling hc_round_fill(const hc_lattice *lattice, const hc_shape *shape) {
  hc_sampling sampling;
  if (shape->round == 1) {
    const hc_lattice own = hc_sampling_own_lattice(lattice);
    sampling = hc_sampling_block(&own, shape->low, shape->high);
  } else {
    sampling = fill_round(begin(lattice, shape));
  }
  hc_sampling_turn(&sampling, lattice, shape);
  return sampling;
}

hc_sampling hc_round_wall(const hc_lattice *lattice, const hc_shape *shape, bool solid, int layers) {
  hc_sampling sampling;
  if (shape->round == 1) {
    const hc_lattice own = hc_sampling_own_lattice(lattice);
    sampling = (solid ? hc_sampling_solid : hc_sampling_container)(&own, shape->low, shape->high, shape->open,
                                                                   layers);
  } else {
    sampling = wall_round(begin(lattice, shape), solid, layers);
  }
  hc_sampling_turn(&sampling, lattice, shape);
  return sampling;
}
