#include "world_frame.h"

#include <math.h>
#include <stdio.h>

static const double max_stretch = 1.1;       /* of a cell edge along a periodic axis */
static const double cell_tolerance = 1e-9;   /* a period this little short of whole cells is whole */
static const double period_tolerance = 1e-6; /* of the period, against whole spacings */
enum { MIN_CELLS = 3, MAX_SPACINGS_PER_RADIUS = 16 };
static const int64_t max_origin_cells = (int64_t)1 << 31;

static const char axis_names[] = "xyz";

static int64_t nearest_even(double units) {
  return 2 * llrint(units / 2);
}

static int64_t whole_cells(double period, double support_radius) {
  return (int64_t)floor(period / support_radius * (1 + cell_tolerance));
}

static bool fits_cells(double period, double support_radius) {
  const int64_t cells = whole_cells(period, support_radius);
  return cells >= MIN_CELLS && period <= max_stretch * (double)cells * support_radius * (1 + cell_tolerance);
}

/* "0.96 or 1.04": the nearest periods of whole spacings that fit whole cells. */
static void nearest_periods(double period, double spacing, double support_radius, char *text, size_t size) {
  const double shortest = MIN_CELLS * support_radius * (1 - cell_tolerance);
  double below = floor(period / spacing), above = fmax(below, floor(shortest / spacing)) + 1;
  while (below * spacing >= shortest && !fits_cells(below * spacing, support_radius)) below--;
  while (!fits_cells(above * spacing, support_radius)) above++;
  if (below * spacing >= shortest)
    snprintf(text, size, "%.9g or %.9g", below * spacing, above * spacing);
  else
    snprintf(text, size, "%.9g", above * spacing);
}

static hc_status check_lengths(const hc_scene *scene, hc_error *error) {
  const double spacing = scene->particle_spacing, radius = scene->support_radius;
  if (!(spacing > 0 && isfinite(spacing)))
    return hc_error_set(error, HC_BAD_INPUT, "particle_spacing must be above 0, got %g m", spacing);
  if (!(radius > spacing && radius <= MAX_SPACINGS_PER_RADIUS * spacing))
    return hc_error_set(
        error, HC_BAD_INPUT,
        "support_radius must be above 1 and at most %d particle_spacing (%g to %g m), got %g m",
        MAX_SPACINGS_PER_RADIUS, spacing, MAX_SPACINGS_PER_RADIUS * spacing, radius);
  for (int a = 0; a < 3; a++) {
    const int64_t cells = scene->origin_cells[a];
    if (cells < -max_origin_cells || cells > max_origin_cells)
      return hc_error_set(error, HC_BAD_INPUT, "origin_cells must lie within +-%lld, got %lld along %c",
                          (long long)max_origin_cells, (long long)cells, axis_names[a]);
  }
  return HC_OK;
}

/* How wide cells are along open axes. */
static double open_edge(const hc_scene *scene) {
  const double margin = scene->time_step.control == HC_TIME_INDIVIDUAL ? scene->time_step.margin : 0.0;
  return (1.0 + margin) * scene->support_radius;
}

static void open_axis(const hc_scene *scene, int axis, hc_frame *frame) {
  frame->unit[axis] = open_edge(scene) / (double)HC_CELL_UNITS;
  frame->spacing[axis] = nearest_even(scene->particle_spacing / frame->unit[axis]);
  frame->origin[axis] = scene->origin_cells[axis] * HC_CELL_UNITS;
  frame->period[axis] = 0;
  frame->low[axis] = 0;
}

static hc_status check_period(const hc_scene *scene, int axis, hc_error *error) {
  const double spacing = scene->particle_spacing, radius = scene->support_radius;
  const double min = scene->domain.min[axis], period = scene->domain.max[axis] - min;
  const char name = axis_names[axis];
  if (!(period > 0) || !(fabs(min) + period <= (double)max_origin_cells * radius))
    return hc_error_set(
        error, HC_BAD_INPUT,
        "domain along %c is periodic: max must be above min, and both within %lld support radii of "
        "the origin; got min %g, max %g m",
        name, (long long)max_origin_cells, min, scene->domain.max[axis]);
  if (!fits_cells(period, radius)) {
    char fitting[64];
    nearest_periods(period, spacing, radius, fitting, sizeof fitting);
    return hc_error_set(
        error, HC_BAD_INPUT,
        "domain along %c is periodic: its length must be a whole number of cells, at least %d, of 1 to "
        "%g support_radius (%g m); got %.9g m; nearest that fit: %s m",
        name, MIN_CELLS, max_stretch, radius, period, fitting);
  }
  const double count = rint(period / spacing);
  if (!(fabs(count * spacing - period) <= period_tolerance * period)) {
    const double fewer = floor(period / spacing);
    return hc_error_set(
        error, HC_BAD_INPUT,
        "domain along %c is periodic: its length, %.9g m, must be a whole number of particle "
        "spacings to %g of the length; got particle_spacing %.9g m; nearest that fit: %.9g or %.9g m",
        name, period, period_tolerance, spacing, period / (fewer + 1), period / fewer);
  }
  return HC_OK;
}

static void periodic_axis(const hc_scene *scene, int axis, hc_frame *frame) {
  const double min = scene->domain.min[axis], period = scene->domain.max[axis] - min;
  const int64_t wide = whole_cells(period, open_edge(scene));
  const int64_t cells = wide >= MIN_CELLS ? wide : whole_cells(period, scene->support_radius);
  const double edge = period / (double)cells;
  frame->unit[axis] = edge / (double)HC_CELL_UNITS;
  frame->period[axis] = cells * HC_CELL_UNITS;
  frame->spacing[axis] = nearest_even((double)frame->period[axis] / rint(period / scene->particle_spacing));
  /* Cells are what the period is made of, so the scene's origin gives way where both cannot be corners. */
  const int64_t min_units = llrint(min / frame->unit[axis]);
  const int64_t min_cell = hc_frame_cell(min_units + HC_CELL_UNITS / 2);
  frame->low[axis] = (scene->origin_cells[axis] + min_cell) * HC_CELL_UNITS;
  frame->origin[axis] = frame->low[axis] - min_units;
  if (edge < frame->support_radius) frame->support_radius = edge;
  if (edge < frame->support_radius + frame->margin) frame->margin = edge - frame->support_radius;
}

hc_status hc_setup_frame(const hc_scene *scene, hc_frame *frame, hc_error *error) {
  hc_status status = check_lengths(scene, error);
  if (status) return status;
  *frame =
      (hc_frame){.support_radius = scene->support_radius, .margin = open_edge(scene) - scene->support_radius};
  for (int a = 0; a < 3; a++) {
    if (!scene->domain.periodic[a]) {
      open_axis(scene, a, frame);
      continue;
    }
    status = check_period(scene, a, error);
    if (status) return status;
    periodic_axis(scene, a, frame);
  }
  return HC_OK;
}
