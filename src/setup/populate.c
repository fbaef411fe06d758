#include "populate.h"

#include "base/memory.h"
#include "geometry/parts.h"
#include "setup/carve.h"
#include "setup/fit.h"
#include "setup/flow.h"
#include "setup/union.h"

/* Adds the air of blocks that rest states fill, and leaves out what does not fit. */
static void fit_rest_states(const hc_scene *scene, hc_setup_plan *plan) {
  const hc_fit fit = hc_setup_fit_of(scene, &plan->frame, plan->boundary);
  for (int number = 0; number < plan->fluid_sources; number++)
    if (plan->fluid[number].sampling.tile.at)
      hc_setup_fit(&fit, &plan->fluid[number], &plan->fluid[plan->fluid_sources + plan->air_sources++]);
}

void hc_setup_velocity(const hc_frame *frame, const hc_setup_source *source, const int64_t position[3],
                       double velocity[3]) {
  double x[3];
  for (int a = 0; a < 3; a++) {
    x[a] = hc_frame_to_metres(frame, a, position[a]);
    velocity[a] = source->velocity[a];
  }
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) velocity[a] += source->gradient[a][b] * (x[b] - source->centre[b]);
  hc_flow_add(&source->flow, x, velocity);
}

static hc_status plan_sources(hc_comm *comm, const hc_scene *scene, hc_setup_plan *plan, hc_error *error) {
  for (int number = 0; number < scene->fluid.block_count; number++) {
    hc_setup_source *const source = &plan->fluid[plan->fluid_sources++];
    const hc_status status =
        hc_source_block(&plan->frame, &scene->fluid.blocks[number], number, source, error);
    if (status) return status;
    if (scene->fluid.blocks[number].start > 0.0) source->sampling = (hc_sampling){0}; /* see refill.h */
  }
  const int layers = hc_setup_layers(scene);
  for (int number = 0; number < hc_scene_surfaces(scene); number++) {
    hc_setup_source *const source = &plan->boundary[plan->boundary_sources++];
    const hc_status status = hc_source_surface(&plan->frame, scene, number, layers, source, error);
    if (status) return status;
  }
  hc_setup_carve(&plan->frame, plan->fluid, plan->fluid_sources, &plan->boundary[scene->boundary.wall_count],
                 scene->body_count);
  fit_rest_states(scene, plan);
  for (int number = 0; number < plan->fluid_sources + plan->air_sources; number++) {
    const bool air = number >= plan->fluid_sources;
    plan->fluid[number].first = plan->fluid_count + plan->air_count;
    *(air ? &plan->air_count : &plan->fluid_count) += hc_source_count(&plan->fluid[number]);
  }
  hc_union_drop(comm, &plan->frame, plan->boundary, plan->boundary_sources);
  for (int number = 0; number < plan->boundary_sources; number++) {
    plan->boundary[number].first = plan->boundary_count;
    plan->boundary_count += hc_source_count(&plan->boundary[number]);
  }
  return HC_OK;
}

hc_status hc_setup_plan_make(hc_comm *comm, const hc_scene *scene, const hc_frame *frame, hc_setup_plan *plan,
                             hc_error *error) {
  *plan = (hc_setup_plan){0};
  const int blocks = scene->fluid.block_count, walls = hc_scene_surfaces(scene);
  if (blocks > HC_ID_MAX_SOURCES || walls > HC_ID_MAX_SOURCES)
    return hc_error_set(
        error, HC_BAD_INPUT,
        "fluid.blocks, and boundary.walls and bodies, must have at most 2^%d entries, got %d and %d",
        HC_ID_SOURCE_BITS, blocks, walls);
  *plan = (hc_setup_plan){.frame = *frame,
                          .fluid = hc_alloc(2 * (size_t)blocks, sizeof(hc_setup_source)),
                          .boundary = hc_alloc((size_t)walls, sizeof(hc_setup_source))};
  for (int a = 0; a < 3; a++)
    plan->disorder[a] = (int64_t)(scene->fluid.disorder * (double)frame->spacing[a]);
  plan->seed = (uint64_t)scene->fluid.seed;
  const hc_status status = plan_sources(comm, scene, plan, error);
  if (status) hc_setup_plan_free(plan);
  return status;
}

void hc_setup_plan_free(hc_setup_plan *plan) {
  for (int s = 0; s < plan->fluid_sources + plan->air_sources; s++) hc_source_free(&plan->fluid[s]);
  for (int s = 0; s < plan->boundary_sources; s++) hc_source_free(&plan->boundary[s]);
  hc_free(plan->fluid);
  hc_free(plan->boundary);
  *plan = (hc_setup_plan){0};
}

void hc_setup_share(int64_t count, int rank, int size, int64_t *first, int64_t *last) {
  hc_parts_share(&(hc_parts){.part = rank, .count = size}, count, first, last);
}

/* Evenly distributed in [-largest, largest], from the id and the seed alone (the mixer of splitmix64, Steele
 * et al. 2014).
 */
static int64_t random_shift(uint64_t seed, uint64_t id, int axis, int64_t largest) {
  uint64_t mixed = (3 * id + (uint64_t)axis + 1) * 0x9e3779b97f4a7c15u + seed * 0xd1342543de82ef95u;
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
  hc_source_put(&plan->frame, source, point);
  const uint64_t id = hc_id_make(source->kind, (uint64_t)source->number, (uint64_t)k);
  particles->id[index] = id;
  for (int a = 0; a < 3; a++) {
    const int64_t shift = source->kind == HC_ID_FLUID && !source->sampling.tile.at
                              ? random_shift(plan->seed, id, a, plan->disorder[a])
                              : 0;
    particles->position[3 * index + a] = hc_frame_wrap(&plan->frame, a, point[a] + shift);
    if (particles->reference) particles->reference[3 * index + a] = point[a];
  }
  if (source->kind != HC_ID_BOUNDARY) return;
  double normal[3];
  hc_source_normal(&plan->frame, source, k, normal);
  hc_source_turn(source, normal);
  for (int a = 0; a < 3; a++) particles->normal[3 * index + a] = (float)normal[a];
}

/* Which of the kept samples of a source, [first, last), are a rank's: fluid in one range of all blocks
 * together, walls each for itself, as the samples of surfaces are shared out. */
static void part_of(const hc_setup_plan *plan, const hc_setup_source *source, int rank, int size,
                    int64_t *first, int64_t *last) {
  if (source->kind == HC_ID_BOUNDARY) {
    hc_setup_share(hc_sampling_count(&source->sampling), rank, size, first, last);
    *first -= hc_gaps_before(&source->gaps, *first);
    *last -= hc_gaps_before(&source->gaps, *last);
    return;
  }
  const int64_t count = hc_source_count(source);
  hc_setup_share(plan->fluid_count + plan->air_count, rank, size, first, last);
  *first = *first < source->first ? 0 : *first - source->first;
  *last = *last < source->first + count ? *last - source->first : count;
}

/* How many of the sources' samples are a rank's: of fluid or walls that stand still, or of what moves. */
static int64_t own_of(const hc_setup_plan *plan, const hc_setup_source *sources, int source_count, bool moved,
                      int rank, int size) {
  int64_t own = 0;
  for (int s = 0; s < source_count; s++) {
    int64_t first, last;
    if (moved != (sources[s].moves > 0)) continue;
    part_of(plan, &sources[s], rank, size, &first, &last);
    if (last > first) own += last - first;
  }
  return own;
}

/* Fills a store with what of the rank's samples belongs to it. */
static void generate(const hc_setup_plan *plan, const hc_setup_source *sources, int source_count, int rank,
                     int size, hc_particles *particles) {
  const bool moved = particles->kind & HC_MOVED;
  hc_particles_resize(particles, 0); /* what it held before must not live on as state */
  hc_particles_resize(particles, (int32_t)own_of(plan, sources, source_count, moved, rank, size));
  int64_t index = 0;
  for (int s = 0; s < source_count; s++) {
    int64_t first, last;
    if (moved != (sources[s].moves > 0)) continue;
    part_of(plan, &sources[s], rank, size, &first, &last);
    for (int64_t at = first; at < last; at++)
      place(plan, &sources[s], hc_gaps_kept(&sources[s].gaps, at), particles, index++);
  }
}

void hc_setup_velocities(const hc_setup_plan *plan, hc_particles *fluid) {
  for (int64_t i = 0; i < fluid->own; i++) {
    const hc_setup_source *const source = &plan->fluid[hc_id_source_of(fluid->id[i])];
    hc_setup_velocity(&plan->frame, source, &fluid->position[3 * i], &fluid->velocity[3 * i]);
  }
}

void hc_setup_add(const hc_frame *frame, const hc_setup_source *source, int rank, int size,
                  hc_particles *fluid) {
  int64_t first, last;
  hc_setup_share(hc_source_count(source), rank, size, &first, &last);
  int64_t index = fluid->own;
  const hc_setup_plan plan = {.frame = *frame};
  hc_particles_resize(fluid, fluid->own + (int32_t)(last - first));
  for (int64_t at = first; at < last; at++) {
    place(&plan, source, hc_gaps_kept(&source->gaps, at), fluid, index);
    hc_setup_velocity(frame, source, &fluid->position[3 * index], &fluid->velocity[3 * index]);
    index++;
  }
}

hc_status hc_setup_check_share(const hc_setup_plan *plan, int rank, int size, hc_error *error) {
  const int64_t fluid_own =
      own_of(plan, plan->fluid, plan->fluid_sources + plan->air_sources, false, rank, size);
  const int64_t boundary_own = own_of(plan, plan->boundary, plan->boundary_sources, false, rank, size) +
                               own_of(plan, plan->boundary, plan->boundary_sources, true, rank, size);
  if (fluid_own > HC_RECORDS_MOST || boundary_own > HC_RECORDS_MOST)
    return hc_error_set(error, HC_BAD_INPUT,
                        "a rank can hold at most %lld particles of a kind; rank %d of %d would get %lld of "
                        "the fluid and %lld of the "
                        "boundary: use more ranks or a larger particle_spacing",
                        (long long)HC_RECORDS_MOST, rank, size, (long long)fluid_own,
                        (long long)boundary_own);
  return HC_OK;
}

hc_status hc_setup_generate(const hc_setup_plan *plan, int rank, int size, hc_particles *fluid,
                            hc_particles *boundary, hc_particles *moving, hc_error *error) {
  const hc_status status = hc_setup_check_share(plan, rank, size, error);
  if (status) return status;
  generate(plan, plan->fluid, plan->fluid_sources + plan->air_sources, rank, size, fluid);
  hc_setup_velocities(plan, fluid);
  generate(plan, plan->boundary, plan->boundary_sources, rank, size, boundary);
  generate(plan, plan->boundary, plan->boundary_sources, rank, size, moving);
  return HC_OK;
}
