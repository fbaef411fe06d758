#include "window.h"

#include "base/memory.h"
#include "base/turns.h"
#include "particles/ids.h"
#include "setup/samples.h"
#include "setup/trace.h"

#include <math.h>
#include <string.h>

enum { DIRECTIONS = 16 };

/* By less than this, spacings, a floor may be deeper or less deep and still be the same. */
static const double SAME = 0.1;

/* ---- made ---- */

/* From a point, where the scene has the container, to its sides across gravity: is any within a distance? */
static bool near_sides(const hc_window *window, const double x[3], double distance) {
  int across[3], axes = 0;
  for (int a = 0; a < 3; a++)
    if (window->goes[a]) across[axes++] = a;
  if (-hc_shape_region_distance(&window->shape, x) > distance)
    return false; /* not even the nearest face is */
  const int directions = axes > 1 ? DIRECTIONS : 2;
  for (int k = 0; k < directions; k++) {
    double at[3] = {x[0], x[1], x[2]};
    const double turns = (double)k / directions;
    at[across[0]] += distance * hc_turns_cosine(turns);
    if (axes > 1) at[across[1]] += distance * hc_turns_sine(turns);
    if (hc_shape_region_distance(&window->shape, at) >= 0.0) return true;
  }
  return false;
}

static hc_status check_room(const hc_scene *scene, const hc_frame *frame, const hc_window *window,
                            const hc_body *body, hc_error *error) {
  const double needed = body->reach + window->trigger + window->new_distance + frame->support_radius;
  double x[3];
  for (int a = 0; a < 3; a++) x[a] = hc_frame_to_metres(frame, a, window->start[a]);
  if (hc_shape_region_distance(&window->shape, x) < 0.0 && !near_sides(window, x, needed)) return HC_OK;
  return hc_error_set(
      error, HC_BAD_INPUT,
      "window.wall \"%s\" must be farther than %.4g m from the middle of \"%s\" on all sides: the body's "
      "reach of %.4g m, the trigger, new_distance and a support radius",
      scene->window.wall, needed, scene->window.follow, body->reach);
}

hc_status hc_window_make(const hc_scene *scene, const hc_setup_plan *plan, const hc_bodies *bodies,
                         hc_window *window, hc_error *error) {
  memset(window, 0, sizeof *window);
  window->there = hc_scene_has_window(scene);
  if (!window->there) return HC_OK;
  const hc_frame *const frame = &plan->frame;
  const double spacing = hc_trace_spacing(frame);
  window->body = hc_scene_surface_named(scene, scene->window.follow) - scene->boundary.wall_count;
  window->shape = plan->boundary[0].shape;
  window->trigger = scene->window.trigger * frame->support_radius;
  window->old_distance = scene->window.old_distance * 0.5 * spacing;
  window->new_distance = scene->window.new_distance * frame->support_radius;
  window->source =
      (uint64_t)(scene->fluid.block_count + scene->fluid.emitter_count + scene->absorption_count);
  int axes = 0;
  for (int a = 0; a < 3; a++) {
    window->goes[a] = scene->gravity[a] == 0.0 && frame->period[a] == 0;
    axes += window->goes[a];
  }
  const hc_body *const body = &bodies->body[window->body];
  memcpy(window->start, body->position, sizeof window->start);
  hc_places_init(&window->places, HC_WINDOW);
  if (axes == 0)
    return hc_error_set(error, HC_BAD_INPUT,
                        "window.follow must not be given where all axes across gravity are periodic");
  if (hc_setup_sample_numbers(plan, &window->samples, error) != HC_OK) return error->status;
  return check_room(scene, frame, window, body, error);
}

void hc_window_free(hc_window *window) {
  if (window->there) hc_places_free(&window->places);
  hc_free(window->samples.first);
  memset(window, 0, sizeof *window);
}

void hc_window_register(hc_window *window, hc_state *state) {
  if (!window->there) return;
  hc_state_add_store(state, &window->places.store);
  hc_state_add(state, HC_TYPE_i64, 3, window->shift, "window.shift");
  hc_state_add(state, HC_TYPE_i64, 1, &window->count, "window.count");
}

void hc_window_remember(hc_window *window, const hc_world *world, hc_id_kind kind) {
  const hc_particles *const fluid = world->fluid;
  hc_arrivals found = {.count = 0};
  for (int32_t k = 0; window->there && k < fluid->own; k++)
    if (hc_id_kind_of(fluid->id[k]) == kind)
      hc_arrivals_add(
          &found,
          hc_id_make(kind, window->source, (uint64_t)hc_sample_number(&window->samples, fluid->id[k])),
          &fluid->position[3 * (size_t)k]);
  if (found.count > 0) hc_places_add(&window->places, &found);
  hc_arrivals_free(&found);
}

/* ---- where it is ---- */

void hc_window_adopt(hc_window *window) {
  memcpy(window->places.shift, window->shift, sizeof window->places.shift);
  window->places.moved = true;
}

void hc_window_pose(hc_window *window, hc_world *world) {
  if (!window->there || memcmp(window->places.shift, window->shift, sizeof window->shift) == 0) return;
  int64_t by[3];
  for (int a = 0; a < 3; a++) by[a] = window->shift[a] - window->places.shift[a];
  hc_places_go(&window->places, &world->frame, window->shift);
  hc_places_translate(world->boundary, &world->frame, by);
  world->stores[HC_STORE_BOUNDARY].moved = true;
}

/* ---- going along ---- */

/* A position, m, where the scene would have it if the window had come by `shift`. */
static void to_scene(const hc_frame *frame, const int64_t position[3], const int64_t shift[3], double x[3]) {
  for (int a = 0; a < 3; a++) x[a] = hc_frame_to_metres(frame, a, position[a] - shift[a]);
}

bool hc_window_decide(hc_window *window, const hc_frame *frame, const hc_bodies *bodies, hc_error *error) {
  if (!window->there) return false;
  const int64_t *const at = bodies->body[window->body].position;
  double square = 0.0, x[3];
  to_scene(frame, at, window->shift, x);
  if (!(hc_shape_region_distance(&window->shape, x) < 0.0)) {
    hc_error_set(error, HC_FAILED, "the body that the window follows has left it, at (%.6g, %.6g, %.6g) m",
                 hc_frame_to_metres(frame, 0, at[0]), hc_frame_to_metres(frame, 1, at[1]),
                 hc_frame_to_metres(frame, 2, at[2]));
    return false;
  }
  int64_t by[3] = {0, 0, 0};
  for (int a = 0; a < 3; a++) {
    if (!window->goes[a]) continue;
    const int64_t off = at[a] - window->start[a] - window->shift[a];
    square += (double)off * frame->unit[a] * ((double)off * frame->unit[a]);
    by[a] = llrint((double)off / (double)frame->spacing[a]) * frame->spacing[a];
  }
  if (square <= window->trigger * window->trigger) return false;
  if (window->count + 2 > HC_ID_MAX_COUNTER / window->samples.count) {
    hc_error_set(error, HC_FAILED, "after %lld displacements there are no more ids for water of the window",
                 (long long)window->count);
    return false;
  }
  memcpy(window->before, window->shift, sizeof window->before);
  for (int a = 0; a < 3; a++) window->shift[a] += by[a];
  window->count++;
  return true;
}

/* Is the water at a position renewed, as the window has just gone along? */
static bool is_renewed(const hc_window *window, const hc_frame *frame, const int64_t position[3]) {
  double was[3], is[3];
  to_scene(frame, position, window->before, was);
  to_scene(frame, position, window->shift, is);
  const double old = -hc_shape_region_distance(&window->shape, was),
               new = -hc_shape_region_distance(&window->shape, is);
  if (old <= 0.0 || new <= 0.0) return true;
  const bool near = old < window->old_distance || new < window->new_distance;
  return near &&
         (fabs(new - old) > SAME * hc_trace_spacing(frame) || near_sides(window, was, window->old_distance) ||
          near_sides(window, is, window->new_distance));
}

static void take_out(const hc_window *window, hc_world *world) {
  hc_particles *const fluid = world->fluid;
  int32_t *const gone = hc_alloc((size_t)fluid->own, sizeof *gone), count = 0;
  for (int32_t k = 0; k < fluid->own; k++)
    if (is_renewed(window, &world->frame, &fluid->position[3 * (size_t)k])) gone[count++] = k;
  if (count > 0) hc_particles_remove(fluid, gone, count);
  hc_free(gone);
}

void hc_window_renew(hc_window *window, hc_world *world, uint64_t *from, uint64_t *to) {
  const uint64_t begin = (uint64_t)(window->count * window->samples.count);
  const hc_particles *const places = &window->places.store;
  hc_arrivals come = {.count = 0};
  hc_places_settle(&window->places, &world->domain);
  take_out(window, world);
  for (int32_t k = 0; k < places->own; k++)
    if (is_renewed(window, &world->frame, &places->position[3 * (size_t)k]))
      hc_arrivals_add(&come,
                      hc_id_make(hc_id_kind_of(places->id[k]), window->source,
                                 begin + (uint64_t)hc_id_counter_of(places->id[k])),
                      &places->position[3 * (size_t)k]);
  hc_arrivals_append(&come, world->fluid);
  hc_arrivals_free(&come);
  *from = hc_id_make(HC_ID_FLUID, window->source, begin);
  *to = *from + (uint64_t)window->samples.count;
}
