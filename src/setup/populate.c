#include "populate.h"

#include "base/memory.h"
#include "setup/flow.h"

#include <math.h>
#include <stdio.h>

static const double max_cells = (double)((int64_t)1 << 31); /* of a coordinate from the scene's origin */
static const int64_t max_own = ((int64_t)1 << 31) - 64; /* local indices are int32_t, with room for padding */
static const char axis_names[] = "xyz";

_Static_assert(HC_FACE_MINUS_X == 1 && HC_FACE_PLUS_X == 2 && HC_FACE_MINUS_Y == 4 && HC_FACE_PLUS_Y == 8 &&
                   HC_FACE_MINUS_Z == 16 && HC_FACE_PLUS_Z == 32,
               "the samplings take the scene's bits of open faces");

/* What messages call a source: boundary.walls[1] "tank". */
typedef struct source_name {
  char text[HC_NAME_LENGTH + 64];
} source_name;

static source_name block_name(int number) {
  source_name name;
  snprintf(name.text, sizeof name.text, "fluid.blocks[%d]", number);
  return name;
}

static source_name wall_name(const hc_wall *wall, int number) {
  source_name name;
  const int length = snprintf(name.text, sizeof name.text, "boundary.walls[%d]", number);
  if (wall->name[0])
    snprintf(name.text + length, sizeof name.text - (size_t)length, " \"%.*s\"", HC_NAME_LENGTH, wall->name);
  return name;
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

static hc_status check_plane(const hc_frame *frame, const hc_wall *wall, const char *name, hc_error *error) {
  double square = 0;
  for (int a = 0; a < 3; a++) {
    square += wall->normal[a] * wall->normal[a];
    if (!in_reach(frame, wall->point[a]))
      return hc_error_set(error, HC_BAD_INPUT,
                          "%s: point must lie within 2^31 support radii of the origin, got %g m along %c",
                          name, wall->point[a], axis_names[a]);
  }
  if (!(square > 0 && isfinite(square)))
    return hc_error_set(error, HC_BAD_INPUT, "%s: the normal must have a length, got [%g, %g, %g]", name,
                        wall->normal[0], wall->normal[1], wall->normal[2]);
  for (int t = 0; t < 2; t++)
    if (!(wall->size[t] > 0 && in_reach(frame, wall->size[t])))
      return hc_error_set(error, HC_BAD_INPUT,
                          "%s: size must be above 0 and within 2^31 support radii, got [%g, %g] m", name,
                          wall->size[0], wall->size[1]);
  return HC_OK;
}

/* Counts must fit the ids, and nothing may meet its own periodic image. */
static hc_status check_sampling(const hc_frame *frame, const hc_sampling *sampling, const char *name,
                                hc_error *error) {
  const int64_t count = hc_sampling_count(sampling);
  if (count > HC_ID_MAX_COUNTER)
    return hc_error_set(error, HC_BAD_INPUT, "%s: must have at most 2^%d particles, got %s%lld", name,
                        HC_ID_COUNTER_BITS, count == INT64_MAX ? "more than " : "",
                        count == INT64_MAX ? 1LL << 62 : (long long)count);
  if (count == 0) return HC_OK;
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
          sampling->part_count > 1 ? " (a container as long as the period: open its faces there)" : "");
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

static hc_status plan_block(const hc_frame *frame, const hc_block *block, hc_setup_source *source,
                            hc_error *error) {
  const source_name name = block_name((int)source->number);
  const hc_status status = check_box(frame, &block->box, name.text, error);
  if (status) return status;
  for (int a = 0; a < 3; a++) {
    if (!isfinite(block->velocity[a]))
      return hc_error_set(error, HC_BAD_INPUT, "%s: velocity must be finite, got %g m/s along %c", name.text,
                          block->velocity[a], axis_names[a]);
    source->velocity[a] = block->velocity[a];
  }
  if (block->flow.type != HC_FLOW_NONE && !(block->flow.length > 0 && isfinite(block->flow.speed)))
    return hc_error_set(error, HC_BAD_INPUT,
                        "%s: flow.length must be above 0 and flow.speed finite, got %g m and %g m/s",
                        name.text, block->flow.length, block->flow.speed);
  source->flow = block->flow;
  const hc_lattice lattice = lattice_of(frame);
  source->sampling = hc_sampling_block(&lattice, block->box.min, block->box.max);
  return check_sampling(frame, &source->sampling, name.text, error);
}

static hc_status plan_wall(const hc_frame *frame, const hc_wall *wall, hc_setup_source *source,
                           hc_error *error) {
  const source_name name = wall_name(wall, (int)source->number);
  const hc_status status = wall->type == HC_WALL_PLANE ? check_plane(frame, wall, name.text, error)
                                                       : check_box(frame, &wall->box, name.text, error);
  if (status) return status;
  const hc_lattice lattice = lattice_of(frame);
  if (wall->type == HC_WALL_PLANE)
    source->sampling = hc_sampling_plane(&lattice, wall->point, wall->normal, wall->size);
  else if (wall->inside == HC_INSIDE_FLUID)
    source->sampling = hc_sampling_container(&lattice, wall->box.min, wall->box.max, wall->open);
  else
    source->sampling = hc_sampling_solid(&lattice, wall->box.min, wall->box.max, wall->open);
  return check_sampling(frame, &source->sampling, name.text, error);
}

static hc_status plan_sources(const hc_scene *scene, hc_setup_plan *plan, hc_error *error) {
  for (int number = 0; number < plan->fluid_sources; number++) {
    hc_setup_source *const source = &plan->fluid[number];
    *source = (hc_setup_source){.kind = HC_ID_FLUID, .number = number, .first = plan->fluid_count};
    const hc_status status = plan_block(&plan->frame, &scene->fluid.blocks[number], source, error);
    if (status) return status;
    plan->fluid_count += hc_sampling_count(&source->sampling);
  }
  for (int number = 0; number < plan->boundary_sources; number++) {
    hc_setup_source *const source = &plan->boundary[number];
    *source = (hc_setup_source){.kind = HC_ID_BOUNDARY, .number = number, .first = plan->boundary_count};
    const hc_status status = plan_wall(&plan->frame, &scene->boundary.walls[number], source, error);
    if (status) return status;
    plan->boundary_count += hc_sampling_count(&source->sampling);
  }
  return HC_OK;
}

hc_status hc_setup_plan_make(const hc_scene *scene, const hc_frame *frame, hc_setup_plan *plan,
                             hc_error *error) {
  *plan = (hc_setup_plan){0};
  const int blocks = scene->fluid.block_count, walls = scene->boundary.wall_count;
  if (blocks > HC_ID_MAX_SOURCES || walls > HC_ID_MAX_SOURCES)
    return hc_error_set(error, HC_BAD_INPUT,
                        "fluid.blocks and boundary.walls must have at most 2^%d entries, got %d and %d",
                        HC_ID_SOURCE_BITS, blocks, walls);
  *plan = (hc_setup_plan){.frame = *frame,
                          .fluid = hc_alloc((size_t)blocks, sizeof(hc_setup_source)),
                          .boundary = hc_alloc((size_t)walls, sizeof(hc_setup_source)),
                          .fluid_sources = blocks,
                          .boundary_sources = walls};
  for (int a = 0; a < 3; a++)
    plan->disorder[a] = (int64_t)(scene->fluid.disorder * (double)frame->spacing[a]);
  const hc_status status = plan_sources(scene, plan, error);
  if (status) hc_setup_plan_free(plan);
  return status;
}

void hc_setup_plan_free(hc_setup_plan *plan) {
  hc_free(plan->fluid);
  hc_free(plan->boundary);
  *plan = (hc_setup_plan){0};
}

/* floor(count part / size) without the product, which may exceed 64 bits. */
static int64_t share_start(int64_t count, int part, int size) {
  return count / size * part + count % size * part / size;
}

void hc_setup_share(int64_t count, int rank, int size, int64_t *first, int64_t *last) {
  *first = share_start(count, rank, size);
  *last = share_start(count, rank + 1, size);
}

/* Evenly distributed in [-largest, largest], from the id alone (the mixer of splitmix64, Steele et al. 2014).
 */
static int64_t random_shift(uint64_t id, int axis, int64_t largest) {
  uint64_t mixed = (3 * id + (uint64_t)axis + 1) * 0x9e3779b97f4a7c15u;
  mixed = (mixed ^ mixed >> 30) * 0xbf58476d1ce4e5b9u;
  mixed = (mixed ^ mixed >> 27) * 0x94d049bb133111ebu;
  mixed ^= mixed >> 31;
  return (int64_t)(mixed % (uint64_t)(2 * largest + 1)) - largest;
}

/* Writes point k of a source as particle `index`. */
static void place(const hc_setup_plan *plan, const hc_setup_source *source, int64_t k,
                  hc_particles *particles, int64_t index) {
  int64_t point[3];
  hc_sampling_point(&source->sampling, k, point);
  const uint64_t id = hc_id_make(source->kind, (uint64_t)source->number, (uint64_t)k);
  particles->id[index] = id;
  for (int a = 0; a < 3; a++) {
    const int64_t shift = source->kind == HC_ID_FLUID ? random_shift(id, a, plan->disorder[a]) : 0;
    particles->position[3 * index + a] = hc_frame_wrap(&plan->frame, a, point[a] + shift);
  }
}

static void generate(const hc_setup_plan *plan, const hc_setup_source *sources, int source_count,
                     int64_t first, int64_t last, hc_particles *particles) {
  hc_particles_resize(particles, 0); /* what it held before must not live on as state */
  hc_particles_resize(particles, (int32_t)(last - first));
  for (int s = 0; s < source_count; s++) {
    const hc_setup_source *const source = &sources[s];
    const int64_t end = source->first + hc_sampling_count(&source->sampling);
    const int64_t from = first > source->first ? first : source->first, to = last < end ? last : end;
    for (int64_t at = from; at < to; at++) place(plan, source, at - source->first, particles, at - first);
  }
}

void hc_setup_velocities(const hc_setup_plan *plan, hc_particles *fluid) {
  for (int64_t i = 0; i < fluid->own; i++) {
    const hc_setup_source *const source = &plan->fluid[hc_id_source_of(fluid->id[i])];
    double x[3], velocity[3];
    for (int a = 0; a < 3; a++) {
      x[a] = hc_frame_to_metres(&plan->frame, a, fluid->position[3 * i + a]);
      velocity[a] = source->velocity[a];
    }
    hc_flow_add(&source->flow, x, velocity);
    for (int a = 0; a < 3; a++) fluid->velocity[3 * i + a] = velocity[a];
  }
}

hc_status hc_setup_check_share(const hc_setup_plan *plan, int rank, int size, hc_error *error) {
  int64_t first, last;
  hc_setup_share(plan->fluid_count, rank, size, &first, &last);
  const int64_t fluid_own = last - first;
  hc_setup_share(plan->boundary_count, rank, size, &first, &last);
  const int64_t boundary_own = last - first;
  if (fluid_own > max_own || boundary_own > max_own)
    return hc_error_set(error, HC_BAD_INPUT,
                        "a rank can hold at most %lld particles of a kind; rank %d of %d would get %lld of "
                        "the fluid and %lld of the "
                        "boundary: use more ranks or a larger particle_spacing",
                        (long long)max_own, rank, size, (long long)fluid_own, (long long)boundary_own);
  return HC_OK;
}

hc_status hc_setup_generate(const hc_setup_plan *plan, int rank, int size, hc_particles *fluid,
                            hc_particles *boundary, hc_error *error) {
  const hc_status status = hc_setup_check_share(plan, rank, size, error);
  if (status) return status;
  int64_t fluid_first, fluid_last, boundary_first, boundary_last;
  hc_setup_share(plan->fluid_count, rank, size, &fluid_first, &fluid_last);
  hc_setup_share(plan->boundary_count, rank, size, &boundary_first, &boundary_last);
  generate(plan, plan->fluid, plan->fluid_sources, fluid_first, fluid_last, fluid);
  hc_setup_velocities(plan, fluid);
  generate(plan, plan->boundary, plan->boundary_sources, boundary_first, boundary_last, boundary);
  return HC_OK;
}
