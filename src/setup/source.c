#include "source.h"

#include "base/check.h"
#include "geometry/round.h"
#include "geometry/surface_sampling.h"
#include "setup/trace.h"
#include "state/rest_state.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double max_cells = (double)((int64_t)1 << 31); /* of a coordinate from the scene's origin */
static const double rounding = 1e-4;   /* spacings, by which samples may lie off their layer */
static const double off_second = 0.25; /* the same of second layers, in solids */
static const char axis_names[] = "xyz";

_Static_assert((int)HC_TILE_UNIT == (int)HC_REST_PARTS, "rest states are handed to samplings as they are");
_Static_assert(HC_FACE_MINUS_X == 1 && HC_FACE_PLUS_X == 2 && HC_FACE_MINUS_Y == 4 && HC_FACE_PLUS_Y == 8 &&
                   HC_FACE_MINUS_Z == 16 && HC_FACE_PLUS_Z == 32,
               "the samplings take the scene's bits of open faces");

hc_source_name hc_source_block_name(int number) {
  hc_source_name name;
  snprintf(name.text, sizeof name.text, "fluid.blocks[%d]", number);
  return name;
}

hc_source_name hc_source_wall_name(const hc_wall *wall, int number) {
  hc_source_name name;
  const int length = snprintf(name.text, sizeof name.text, "boundary.walls[%d]", number);
  if (wall->name[0])
    snprintf(name.text + length, sizeof name.text - (size_t)length, " \"%.*s\"", HC_NAME_LENGTH, wall->name);
  return name;
}

hc_source_name hc_source_body_name(const hc_scene_body *body, int number) {
  hc_source_name name;
  snprintf(name.text, sizeof name.text, "bodies[%d] \"%.*s\"", number, HC_NAME_LENGTH, body->surface.name);
  return name;
}

hc_source_name hc_source_surface_name(const hc_scene *scene, int number) {
  const int walls = scene->boundary.wall_count;
  return number < walls ? hc_source_wall_name(&scene->boundary.walls[number], number)
                        : hc_source_body_name(&scene->bodies[number - walls], number - walls);
}

static bool in_reach(const hc_frame *frame, double metres) {
  return fabs(metres) <= max_cells * frame->support_radius; /* false for NaN */
}

static hc_status check_box(const hc_frame *frame, const hc_box *box, const char *name, hc_error *error) {
  for (int a = 0; a < 3; a++) {
    if (!in_reach(frame, box->min[a]) || !in_reach(frame, box->max[a]))
      return hc_error_set(
          error, HC_BAD_INPUT,
          "%s: coordinates must lie within 2^31 support radii of the origin, got %g to %g m along %c", name,
          box->min[a], box->max[a], axis_names[a]);
    if (!(box->max[a] > box->min[a]))
      return hc_error_set(error, HC_BAD_INPUT, "%s: box.max must be above box.min, got %g to %g m along %c",
                          name, box->min[a], box->max[a], axis_names[a]);
  }
  return HC_OK;
}

static hc_status check_point(const hc_frame *frame, const double x[3], const char *what, const char *name,
                             hc_error *error) {
  for (int a = 0; a < 3; a++)
    if (!in_reach(frame, x[a]))
      return hc_error_set(error, HC_BAD_INPUT,
                          "%s: %s must lie within 2^31 support radii of the origin, got %g m along %c", name,
                          what, x[a], axis_names[a]);
  return HC_OK;
}

static hc_status check_direction(const double v[3], const char *what, const char *name, hc_error *error) {
  const double largest = fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2])));
  if (largest > 0 && isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2])) return HC_OK;
  return hc_error_set(error, HC_BAD_INPUT, "%s: the %s must have a length, got [%g, %g, %g]", name, what,
                      v[0], v[1], v[2]);
}

static hc_status check_length(const hc_frame *frame, double length, const char *what, const char *name,
                              hc_error *error) {
  if (length > 0 && in_reach(frame, length)) return HC_OK;
  return hc_error_set(error, HC_BAD_INPUT, "%s: %s must be above 0 and within 2^31 support radii, got %g m",
                      name, what, length);
}

static hc_status check_plane(const hc_frame *frame, const hc_wall *wall, const char *name, hc_error *error) {
  hc_status status = check_point(frame, wall->point, "point", name, error);
  if (!status) status = check_direction(wall->normal, "normal", name, error);
  for (int t = 0; t < 2 && !status; t++) status = check_length(frame, wall->size[t], "size", name, error);
  return status;
}

static hc_status check_cylinder(const hc_frame *frame, const hc_cylinder *cylinder, const char *name,
                                hc_error *error) {
  hc_status status = check_point(frame, cylinder->base, "base", name, error);
  if (!status) status = check_direction(cylinder->axis, "axis", name, error);
  if (!status) status = check_length(frame, cylinder->radius, "radius", name, error);
  if (!status) status = check_length(frame, cylinder->length, "length", name, error);
  return status;
}

static hc_status check_sphere(const hc_frame *frame, const hc_sphere *sphere, const char *name,
                              hc_error *error) {
  const hc_status status = check_point(frame, sphere->center, "center", name, error);
  return status ? status : check_length(frame, sphere->radius, "radius", name, error);
}

static hc_status check_turned_box(const hc_frame *frame, const hc_box *box, const hc_rotation *rotation,
                                  const char *name, hc_error *error) {
  const hc_status status = check_box(frame, box, name, error);
  if (status || rotation->angle == 0) return status;
  if (!isfinite(rotation->angle))
    return hc_error_set(error, HC_BAD_INPUT, "%s: rotation.angle must be finite, got %g degrees", name,
                        rotation->angle);
  return check_direction(rotation->axis, "rotation.axis", name, error);
}

/* What blocks and walls have in common. */
typedef struct form {
  hc_form form;
  const hc_box *box;
  const hc_rotation *rotation;
  const hc_cylinder *cylinder;
  const hc_sphere *sphere;
  unsigned open;
  const hc_surface *surface;
} form;

static form form_of_block(const hc_block *block) {
  return (form){block->form,    &block->box, &block->rotation,   &block->cylinder,
                &block->sphere, 0,           block->made.surface};
}

static bool is_surface(hc_form f) {
  return f == HC_FORM_MESH || f == HC_FORM_REVOLUTION;
}

/* Not of a plane. */
static hc_status check_form(const hc_frame *frame, const form *f, const char *name, hc_error *error) {
  if (is_surface(f->form)) {
    HC_CHECK(f->surface, "%s has a surface that was not made", name);
    return HC_OK; /* it was looked at when it was made */
  }
  if (f->form == HC_FORM_CYLINDER) return check_cylinder(frame, f->cylinder, name, error);
  if (f->form == HC_FORM_SPHERE) return check_sphere(frame, f->sphere, name, error);
  return check_turned_box(frame, f->box, f->rotation, name, error);
}

static hc_shape shape_of(const form *f) {
  if (is_surface(f->form)) return hc_surface_sampling_shape(f->surface);
  if (f->form == HC_FORM_CYLINDER)
    return hc_shape_cylinder(f->cylinder->base, f->cylinder->axis, f->cylinder->radius, f->cylinder->length,
                             f->open / HC_FACE_BASE);
  if (f->form == HC_FORM_SPHERE) return hc_shape_sphere(f->sphere->center, f->sphere->radius);
  return hc_shape_box(f->box->min, f->box->max, f->rotation->axis, f->rotation->angle / 360, f->open);
}

static bool is_plain_box(const form *f) {
  return f->form == HC_FORM_BOX && f->rotation->angle == 0;
}

/* Counts must fit the ids. */
static hc_status check_count(const hc_sampling *sampling, const char *name, hc_error *error) {
  const int64_t count = hc_sampling_count(sampling);
  if (count <= HC_ID_MAX_COUNTER) return HC_OK;
  return hc_error_set(error, HC_BAD_INPUT, "%s: must have at most 2^%d particles, got %s%lld", name,
                      HC_ID_COUNTER_BITS, count == INT64_MAX ? "more than " : "",
                      count == INT64_MAX ? HC_ID_MAX_COUNTER : (long long)count);
}

/* The same, and nothing may meet its own periodic image. */
static hc_status check_sampling(const hc_frame *frame, const hc_sampling *sampling, bool closed,
                                const char *name, hc_error *error) {
  if (check_count(sampling, name, error) != HC_OK) return error->status;
  if (hc_sampling_count(sampling) == 0) return HC_OK;
  int64_t low[3], high[3];
  hc_sampling_bounds(sampling, low, high);
  for (int a = 0; a < 3; a++)
    if (frame->period[a] > 0 && high[a] - low[a] > frame->period[a] - frame->spacing[a] / 2)
      return hc_error_set(
          error, HC_BAD_INPUT,
          "%s: must not meet itself around the period of %g m along %c: its particles span %g m and "
          "must span at most the period less half a spacing%s",
          name, (double)frame->period[a] * frame->unit[a], axis_names[a],
          (double)(high[a] - low[a]) * frame->unit[a],
          closed ? " (a container as long as the period: open its faces there)" : "");
  return HC_OK;
}

static hc_lattice lattice_of(const hc_frame *frame) {
  hc_lattice lattice;
  for (int a = 0; a < 3; a++) {
    lattice.unit[a] = frame->unit[a];
    lattice.origin[a] = frame->origin[a];
    lattice.spacing[a] = frame->spacing[a];
  }
  return lattice;
}

void hc_source_block_gradient(const hc_block *block, double gradient[3][3]) {
  for (int a = 0; a < 3; a++) {
    const int b = (a + 1) % 3, c = (a + 2) % 3; /* omega x r */
    memcpy(gradient[a], block->velocity_gradient[a], sizeof gradient[a]);
    gradient[a][c] += block->angular_velocity[b];
    gradient[a][b] -= block->angular_velocity[c];
  }
}

bool hc_source_fills_period(const hc_frame *frame, const hc_setup_source *block, int axis) {
  double low[3], high[3];
  hc_shape_bounds(&block->shape, low, high);
  const double period = (double)frame->period[axis] * frame->unit[axis];
  return period > 0.0 &&
         high[axis] - low[axis] > period - 0.5 * (double)frame->spacing[axis] * frame->unit[axis];
}

/* Images of the rest state all over the block and the air around it. */
static hc_status tile_block(const hc_frame *frame, const hc_lattice *lattice, const hc_block *block,
                            const char *name, hc_setup_source *source, hc_error *error) {
  const hc_rest_state *const state = block->rest.state;
  hc_sampling_tile tile = {.at = (const int32_t(*)[3])state->position, .count = state->count};
  double low[3], high[3];
  hc_shape_bounds(&source->shape, low, high);
  for (int a = 0; a < 3; a++) {
    const double around = hc_source_fills_period(frame, source, a) ? 0.0 : frame->support_radius;
    tile.extent[a] = state->extent[a];
    low[a] -= around;
    high[a] += around;
  }
  source->sampling = hc_sampling_tiled(lattice, &tile, block->rest_offset, low, high);
  return check_count(&source->sampling, name, error);
}

hc_status hc_source_block(const hc_frame *frame, const hc_block *block, int number, hc_setup_source *source,
                          hc_error *error) {
  *source = (hc_setup_source){.kind = HC_ID_FLUID, .number = number};
  const hc_source_name name = hc_source_block_name(number);
  const form f = form_of_block(block);
  const hc_status status = check_form(frame, &f, name.text, error);
  if (status) return status;
  for (int a = 0; a < 3; a++) {
    if (!isfinite(block->velocity[a]))
      return hc_error_set(error, HC_BAD_INPUT, "%s: velocity must be finite, got %g m/s along %c", name.text,
                          block->velocity[a], axis_names[a]);
    source->velocity[a] = block->velocity[a];
    source->centre[a] = block->velocity_center[a];
  }
  hc_source_block_gradient(block, source->gradient);
  if (block->flow.type != HC_FLOW_NONE && !(block->flow.length > 0 && isfinite(block->flow.speed)))
    return hc_error_set(error, HC_BAD_INPUT,
                        "%s: flow.length must be above 0 and flow.speed finite, got %g m and %g m/s",
                        name.text, block->flow.length, block->flow.speed);
  source->flow = block->flow;
  source->shape = shape_of(&f);
  const hc_lattice lattice = lattice_of(frame);
  if (block->rest.state) return tile_block(frame, &lattice, block, name.text, source, error);
  source->sampling = is_plain_box(&f)     ? hc_sampling_block(&lattice, block->box.min, block->box.max)
                     : is_surface(f.form) ? hc_surface_sampling_fill(&lattice, f.surface)
                                          : hc_round_fill(&lattice, &source->shape);
  return check_sampling(frame, &source->sampling, false, name.text, error);
}

static hc_sampling sample_wall(const hc_lattice *lattice, const hc_wall *wall, const form *f,
                               const hc_setup_source *source) {
  const int layers = source->layers;
  if (wall->form == HC_FORM_PLANE)
    return hc_sampling_plane(lattice, wall->point, wall->normal, wall->size, layers);
  if (is_surface(wall->form)) return hc_surface_sampling_wall(lattice, f->surface);
  if (!is_plain_box(f)) return hc_round_wall(lattice, &source->shape, source->solid, layers);
  return (source->solid ? hc_sampling_solid : hc_sampling_container)(lattice, wall->box.min, wall->box.max,
                                                                     wall->open, layers);
}

int hc_setup_layers(const hc_scene *scene) {
  if (scene->boundary.layers > 0) return scene->boundary.layers;
  switch (scene->boundary.method) {
  case HC_BOUNDARY_IHMSEN2010:
    return 2;
  case HC_BOUNDARY_AKINCI2012:
  case HC_BOUNDARY_BECKER2009:
  case HC_BOUNDARY_HARADA2007:
    return 1;
  }
  HC_CHECK(false, "unknown boundary method %d", (int)scene->boundary.method);
}

static form form_of_wall(const hc_wall *wall) {
  return (form){wall->form,    &wall->box, &wall->rotation,   &wall->cylinder,
                &wall->sphere, wall->open, wall->made.surface};
}

hc_shape hc_source_wall_shape(const hc_wall *wall) {
  const form f = form_of_wall(wall);
  return shape_of(&f);
}

/* `name`: what messages call it. */
static hc_status make_wall(const hc_frame *frame, const hc_wall *wall, int number, int layers,
                           const char *name, hc_setup_source *source, hc_error *error) {
  const bool plane = wall->form == HC_FORM_PLANE;
  *source = (hc_setup_source){.kind = HC_ID_BOUNDARY,
                              .number = number,
                              .layers = layers,
                              .off = layers > 1 ? off_second : rounding,
                              .solid = !plane && wall->inside == HC_INSIDE_SOLID};
  const form f = form_of_wall(wall);
  const hc_status status = plane ? check_plane(frame, wall, name, error) : check_form(frame, &f, name, error);
  if (status) return status;
  if (is_surface(wall->form)) {
    source->off = layers > 1 ? 1.5 : 0.5; /* at mitred edges */
    source->solid = source->solid && f.surface->closed;
  }
  const hc_lattice lattice = lattice_of(frame);
  source->shape = plane ? hc_shape_rectangle(wall->point, wall->normal, wall->size) : shape_of(&f);
  for (int l = 0; l < layers; l++)
    source->layer[l] = hc_shape_layer(&source->shape, hc_trace_spacing(frame), source->solid, l);
  source->sampling = sample_wall(&lattice, wall, &f, source);
  return check_sampling(frame, &source->sampling, !plane, name, error);
}

hc_status hc_source_wall(const hc_frame *frame, const hc_wall *wall, int number, int layers,
                         hc_setup_source *source, hc_error *error) {
  const hc_status status =
      make_wall(frame, wall, number, layers, hc_source_wall_name(wall, number).text, source, error);
  if (wall->motion.type != HC_WALL_STANDS) source->moves = number + 1;
  return status;
}

/* Where a body starts, from where its shape is. */
static hc_start start_of(const hc_scene_body *body) {
  const hc_rotation *const turned = &body->turned;
  const double low[3] = {0.0, 0.0, 0.0}, high[3] = {1.0, 1.0, 1.0};
  const hc_shape axes = hc_shape_box(low, high, turned->axis, turned->angle / 360, 0);
  hc_start start = {.moved = turned->angle != 0.0};
  for (int a = 0; a < 3; a++) {
    for (int b = 0; b < 3; b++) start.turn[a][b] = axes.axes[b][a];
    start.from[a] = body->center_of_mass[a];
    start.to[a] = body->position[a];
    start.moved |= start.to[a] != start.from[a];
  }
  return start;
}

hc_status hc_source_surface(const hc_frame *frame, const hc_scene *scene, int number, int layers,
                            hc_setup_source *source, hc_error *error) {
  const hc_wall *const surface = hc_scene_surface(scene, number);
  if (!hc_scene_is_body(scene, number)) return hc_source_wall(frame, surface, number, layers, source, error);
  const hc_scene_body *const body = &scene->bodies[number - scene->boundary.wall_count];
  const hc_status status =
      make_wall(frame, surface, number, layers, hc_source_surface_name(scene, number).text, source, error);
  source->moves = number + 1;
  if (!status) source->start = start_of(body);
  return status;
}

void hc_source_put(const hc_frame *frame, const hc_setup_source *source, int64_t point[3]) {
  const hc_start *const start = &source->start;
  if (!start->moved) return;
  double arm[3];
  for (int a = 0; a < 3; a++)
    arm[a] = (double)(point[a] - hc_frame_to_units(frame, a, start->from[a])) * frame->unit[a];
  hc_source_turn(source, arm);
  for (int a = 0; a < 3; a++)
    point[a] = hc_frame_to_units(frame, a, start->to[a]) + llrint(arm[a] / frame->unit[a]);
}

void hc_source_turn(const hc_setup_source *source, double direction[3]) {
  if (!source->start.moved) return;
  const double v[3] = {direction[0], direction[1], direction[2]};
  for (int a = 0; a < 3; a++)
    direction[a] =
        source->start.turn[a][0] * v[0] + source->start.turn[a][1] * v[1] + source->start.turn[a][2] * v[2];
}

void hc_source_free(hc_setup_source *source) {
  hc_sampling_free(&source->sampling);
  hc_gaps_free(&source->gaps);
}

double hc_source_layer_distance(const hc_frame *frame, const hc_setup_source *wall, const double x[3]) {
  double nearest = INFINITY;
  for (int l = 0; l < wall->layers; l++)
    nearest = fmin(nearest, hc_trace_distance(frame, hc_shape_surface_distance, &wall->layer[l], x));
  return nearest;
}

double hc_source_layer_reach(const hc_setup_source *wall) {
  double reach = 0;
  for (int l = 0; l < wall->layers; l++) reach = fmax(reach, hc_shape_reach(&wall->layer[l]));
  return reach;
}

void hc_source_normal(const hc_frame *frame, const hc_setup_source *wall, int64_t k, double normal[3]) {
  if (wall->sampling.listed) {
    const hc_surface_sample *const sample = &wall->sampling.listed[k - wall->sampling.listed_first];
    for (int a = 0; a < 3; a++) normal[a] = sample->normal[a];
    return;
  }
  int64_t point[3];
  double x[3];
  hc_sampling_point(&wall->sampling, k, point);
  for (int a = 0; a < 3; a++) x[a] = hc_frame_to_metres(frame, a, point[a]);
  hc_shape_sample_normal(&wall->shape, hc_trace_spacing(frame), wall->solid, x, normal);
}

double hc_source_thickness(const hc_setup_source *source) {
  const hc_shape *const shape = &source->shape;
  double thinnest = INFINITY;
  for (int c = 0; c < hc_shape_components(shape); c++)
    thinnest =
        fmin(thinnest, shape->round > 1 && c == 0 ? 2 * shape->high[0] : shape->high[c] - shape->low[c]);
  for (int a = 0; a < 3 && shape->surface; a++)
    thinnest = fmin(thinnest, shape->surface->high[a] - shape->surface->low[a]);
  return thinnest;
}

int64_t hc_source_count(const hc_setup_source *source) {
  return hc_sampling_count(&source->sampling) - hc_gaps_total(&source->gaps);
}

hc_box hc_source_block_bounds(const hc_block *block) {
  if (block->form == HC_FORM_BOX && block->rotation.angle == 0) return block->box;
  const form f = form_of_block(block);
  const hc_shape shape = shape_of(&f);
  hc_box bounds;
  hc_shape_bounds(&shape, bounds.min, bounds.max);
  return bounds;
}
