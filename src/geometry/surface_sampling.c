#include "surface_sampling.h"

#include "vector.h"

static const double most_rows = 1 << 24; /* more is refused, for they are looked at and stored */
static const double slack = 1e-4;        /* spacings: decimal fractions */

hc_shape hc_surface_sampling_shape(const hc_surface *surface) {
  hc_shape shape = {.axes = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .round = HC_SHAPE_SURFACE, .surface = surface};
  for (int a = 0; a < 3; a++) {
    shape.centre[a] = 0.5 * (surface->low[a] + surface->high[a]);
    shape.high[a] = 0.5 * (surface->high[a] - surface->low[a]);
    shape.low[a] = -shape.high[a];
  }
  return shape;
}

hc_sampling hc_surface_sampling_wall(const hc_lattice *lattice, const hc_surface *surface) {
  hc_sampling sampling = {.count = surface->sample_count,
                          .listed = surface->samples,
                          .listed_first = surface->first_sample,
                          .listed_end = surface->first_sample + surface->samples_held,
                          .turned = true};
  for (int a = 0; a < 3; a++) {
    sampling.listed_low[a] = surface->samples_low[a];
    sampling.listed_high[a] = surface->samples_high[a];
    sampling.centre[a] = lattice->origin[a];
    sampling.turn[a][a] = 1 / lattice->unit[a];
  }
  return sampling;
}

typedef struct filling {
  const hc_surface *surface;
  double metres; /* the spacing */
  double units;
  double count; /* of places in a row */
  hc_sampling sampling;
} filling;

/* The stretches of row (j, k) that are deep enough. Where a point is deeper, or less deep, by d than it must
 * be, its neighbours within d are as it is. */
static void fill_row(filling *f, double j, double k) {
  const double *const low = f->surface->low;
  double from = -1; /* where the stretch began */
  for (double i = 0; i <= f->count;) {
    double spare = -INFINITY;
    if (i < f->count) {
      const double x[3] = {low[0] + (i + 0.5) * f->metres, low[1] + (j + 0.5) * f->metres,
                           low[2] + (k + 0.5) * f->metres};
      spare = -hc_surface_signed_distance(f->surface, x, NULL) / f->metres - 0.5 + slack;
    }
    if (spare >= 0) {
      if (from < 0) from = i;
      i = fmin(f->count, i + 1 + floor(spare));
      continue;
    }
    if (from >= 0) {
      const hc_sampling_run row = {
          .at = {(from + 0.5) * f->units, (j + 0.5) * f->units, (k + 0.5) * f->units},
          .rise = f->units,
          .count = (int64_t)(i - from),
          .repeat = 1};
      hc_sampling_add_run(&f->sampling, &row);
      from = -1;
    }
    i += fmax(1, ceil(-spare));
  }
}

hc_sampling hc_surface_sampling_fill(const hc_lattice *lattice, const hc_surface *surface) {
  filling f = {.surface = surface,
               .units = (double)lattice->spacing[0],
               .metres = (double)lattice->spacing[0] * lattice->unit[0]};
  double count[3];
  for (int a = 0; a < 3; a++) count[a] = hc_sampling_whole((surface->high[a] - surface->low[a]) / f.metres);
  f.sampling.pitch = f.units;
  f.count = count[0];
  if (count[0] > most_rows || count[1] * count[2] > most_rows) {
    f.sampling.count = INT64_MAX;
    return f.sampling;
  }
  for (double k = 0; k < count[2]; k++)
    for (double j = 0; j < count[1]; j++) fill_row(&f, j, k);
  hc_shape corner = hc_surface_sampling_shape(surface);
  for (int a = 0; a < 3; a++) corner.centre[a] = surface->low[a];
  hc_sampling_turn(&f.sampling, lattice, &corner);
  return f.sampling;
}
