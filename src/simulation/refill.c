#include "refill.h"

#include "base/memory.h"
#include "particles/ids.h"
#include "rigid/bodies.h"
#include "setup/controls.h"
#include "setup/fit.h"
#include "setup/trace.h"

#include <math.h>
#include <string.h>

/* Is a block due that has not come? */
static bool is_due(const hc_simulation *simulation, int number) {
  const double start = simulation->scene->fluid.blocks[number].start;
  return start > simulation->refilled && start <= simulation->time;
}

static bool any_due(const hc_simulation *simulation) {
  bool any = false;
  for (int k = 0; k < simulation->scene->fluid.block_count; k++) any |= is_due(simulation, k);
  return any;
}

/* From where the shape is to where the body stands now: as it starts, then turned on. */
static void move_start(const hc_frame *frame, const hc_body *body, hc_start *start) {
  start->moved = true;
  for (int b = 0; b < 3; b++) {
    const double axis[3] = {start->turn[0][b], start->turn[1][b], start->turn[2][b]};
    double turned[3];
    hc_body_turned(body, axis, turned);
    for (int a = 0; a < 3; a++) start->turn[a][b] = turned[a];
    start->to[b] = hc_frame_to_metres(frame, b, body->position[b]);
  }
}

/* Walls and bodies as they stand now. */
static hc_status make_surfaces(const hc_simulation *simulation, hc_setup_source *surfaces, int *made,
                               hc_error *error) {
  const hc_scene *const scene = simulation->scene;
  const hc_frame *const frame = &simulation->world.frame;
  for (*made = 0; *made < hc_scene_surfaces(scene);) {
    hc_setup_source *const source = &surfaces[*made];
    const hc_status status = hc_source_surface(frame, scene, *made, hc_setup_layers(scene), source, error);
    ++*made;
    if (status != HC_OK) return status;
    const hc_body *const body = hc_bodies_of(&simulation->bodies, *made - 1);
    if (body) move_start(frame, body, &source->start);
  }
  return HC_OK;
}

/* Takes out fluid within the block's shape. Local. */
static void take_out(const hc_simulation *simulation, const hc_setup_source *block) {
  const hc_frame *const frame = &simulation->world.frame;
  hc_particles *const fluid = simulation->world.fluid;
  int32_t *const indices = hc_alloc((size_t)fluid->own, sizeof *indices);
  int32_t found = 0;
  for (int32_t i = 0; i < fluid->own; i++) {
    double x[3];
    for (int axis = 0; axis < 3; axis++)
      x[axis] = hc_frame_to_metres(frame, axis, fluid->position[3 * (size_t)i + (size_t)axis]);
    if (hc_trace_distance(frame, hc_shape_distance, &block->shape, x) <= 0.0) indices[found++] = i;
  }
  if (found) hc_particles_remove(fluid, indices, found);
  hc_free(indices);
}

/* Particles that had come get the velocity of their block back, which coming to rest took. */
static void set_velocities(const hc_simulation *simulation, const hc_setup_source *block) {
  hc_particles *const fluid = simulation->world.fluid;
  for (int32_t i = 0; i < fluid->own; i++)
    if (hc_id_source_of(fluid->id[i]) == block->number)
      hc_setup_velocity(&simulation->world.frame, block, &fluid->position[3 * (size_t)i],
                        &fluid->velocity[3 * (size_t)i]);
}

/* Can every rank hold its share of what comes? Agreed. */
static hc_status check_room(const hc_simulation *simulation, const hc_setup_source *source, hc_error *error) {
  const hc_comm *const comm = simulation->comm;
  int64_t first, last;
  hc_setup_share(hc_source_count(source), comm->rank, comm->size, &first, &last);
  const int64_t all = simulation->world.fluid->own + last - first;
  if (all > HC_RECORDS_MOST)
    hc_error_set(error, HC_FAILED,
                 "rank %d would hold %lld fluid particles, and %lld are the most: use more ranks", comm->rank,
                 (long long)all, (long long)HC_RECORDS_MOST);
  return hc_comm_agree(simulation->comm, error);
}

/* The control must know how fast they are: of all fluid, as the start does. Collective. */
static void tell_speed(hc_simulation *simulation) {
  double square = hc_fastest(simulation->world.fluid);
  hc_comm_max_f64(simulation->comm, &square, 1);
  simulation->report.v_max = fmax(simulation->report.v_max, sqrt(square));
}

/* What went wrong, with the block and the time. */
static void name_block(const hc_simulation *simulation, int number, hc_error *error) {
  const hc_error found = *error;
  hc_error_set(error, found.status, "%s, which comes at %g s: %.4000s", hc_source_block_name(number).text,
               simulation->time, found.text);
}

static hc_status fill(hc_simulation *simulation, int number, const hc_fit *fit, hc_error *error) {
  const hc_scene *const scene = simulation->scene;
  hc_world *const world = &simulation->world;
  hc_setup_source *const source = hc_alloc_zero(2, sizeof *source), *const air = source + 1;
  hc_source_block(&world->frame, &scene->fluid.blocks[number], number, source, error);
  if (error->status == HC_OK) {
    bool *const fresh = hc_alloc_zero((size_t)scene->fluid.block_count, sizeof *fresh);
    hc_setup_fit(fit, source, air);
    if (scene->fluid.blocks[number].replaces) take_out(simulation, source);
    for (int k = 0; k < 2 && check_room(simulation, &source[k], error) == HC_OK; k++)
      hc_setup_add(&world->frame, &source[k], world->comm->rank, world->comm->size, world->fluid);
    fresh[number] = true;
    hc_world_count_fluid(world);
    const double dt = simulation->dt > 0.0 ? simulation->dt : hc_setup_calm_step(scene);
    if (error->status == HC_OK &&
        hc_simulation_fit(simulation, &scene->fluid.rest,
                          &(hc_rest_fresh){.source = fresh, .sources = scene->fluid.block_count}, dt,
                          error) == HC_OK) {
      set_velocities(simulation, source);
      tell_speed(simulation);
    }
    hc_free(fresh);
    hc_gaps_free(&air->gaps);
  }
  hc_source_free(source);
  hc_free(source);
  if (error->status != HC_OK) name_block(simulation, number, error);
  return error->status;
}

hc_status hc_simulation_refill(hc_simulation *simulation, hc_error *error) {
  const hc_scene *const scene = simulation->scene;
  simulation->came = any_due(simulation);
  if (!simulation->came) return HC_OK;
  const int count = hc_scene_surfaces(scene);
  hc_setup_source *const surfaces = hc_alloc_zero((size_t)count, sizeof *surfaces);
  int made = 0;
  if (make_surfaces(simulation, surfaces, &made, error) == HC_OK) {
    const hc_fit fit = hc_setup_fit_of(scene, &simulation->world.frame, surfaces);
    for (int k = 0; k < scene->fluid.block_count && error->status == HC_OK; k++)
      if (is_due(simulation, k)) fill(simulation, k, &fit, error);
  }
  for (int k = 0; k < made; k++) hc_source_free(&surfaces[k]);
  hc_free(surfaces);
  simulation->refilled = simulation->time;
  return error->status;
}
