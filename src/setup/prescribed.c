#include "prescribed.h"

#include "base/memory.h"
#include "geometry/vector.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double TWO_PI = 2 * 3.14159265358979323846;

/* ---- motions ---- */

static hc_motion motion_of(const hc_wall_motion *given, hc_motion_row *rows) {
  static const hc_motion_law laws[] = {[HC_WALL_STANDS] = HC_MOTION_STILL,
                                       [HC_WALL_CONSTANT] = HC_MOTION_CONSTANT,
                                       [HC_WALL_COSINE] = HC_MOTION_COSINE,
                                       [HC_WALL_TABLE] = HC_MOTION_TABLE};
  hc_motion motion = {.law = laws[given->type],
                      .start = given->start,
                      .stop = given->stop > 0.0 ? given->stop : INFINITY,
                      .frequency = given->frequency,
                      .phase = given->phase / 360,
                      .smooth = given->interpolation == HC_INTERPOLATION_SMOOTH,
                      .rows = rows,
                      .row_count = given->type == HC_WALL_TABLE ? given->point_count : 0};
  memcpy(motion.centre, given->center, sizeof motion.centre);
  hc_vector_direction(given->axis, motion.axis);
  if (motion.law == HC_MOTION_CONSTANT) {
    memcpy(motion.shift, given->velocity, sizeof motion.shift);
    motion.turns = given->angular_velocity / TWO_PI;
  }
  if (motion.law == HC_MOTION_COSINE) {
    const double per_speed = 1 / (TWO_PI * given->frequency);
    const double amplitude = given->speed > 0.0 ? given->speed * per_speed : given->amplitude;
    double direction[3];
    hc_vector_direction(given->direction, direction);
    for (int a = 0; a < 3; a++) motion.shift[a] = amplitude * direction[a];
    motion.turns = given->angle > 0.0 ? given->angle / 360 : given->angular_velocity * per_speed / TWO_PI;
  }
  for (int k = 0; k < motion.row_count; k++) {
    const hc_motion_point *point = &given->points[k];
    rows[k] = (hc_motion_row){.time = point->time, .turns = point->angle / 360};
    memcpy(rows[k].shift, point->shift, sizeof rows[k].shift);
  }
  return motion;
}

/* From the motion's centre to the farthest corner around the samples, m. */
double hc_prescribed_reach(const hc_frame *frame, const hc_setup_source *source, const double centre[3]) {
  if (hc_sampling_count(&source->sampling) == 0) return 0.0;
  int64_t low[3], high[3];
  hc_sampling_bounds(&source->sampling, low, high);
  double square = 0.0;
  for (int a = 0; a < 3; a++) {
    const double farthest = fmax(fabs(hc_frame_to_metres(frame, a, low[a]) - centre[a]),
                                 fabs(hc_frame_to_metres(frame, a, high[a]) - centre[a]));
    square += farthest * farthest;
  }
  return sqrt(square);
}

hc_movers hc_prescribed_movers_make(const hc_scene *scene, const hc_setup_plan *plan) {
  int rows = 0, walls = scene->body_count;
  for (int k = 0; k < scene->boundary.wall_count; k++) {
    const hc_wall_motion *motion = &scene->boundary.walls[k].motion;
    walls += motion->type != HC_WALL_STANDS;
    rows += motion->type == HC_WALL_TABLE ? motion->point_count : 0;
  }
  hc_movers made;
  hc_movers_init(&made, walls, rows);
  hc_motion_row *next = made.rows;
  hc_mover *wall = made.walls;
  for (int k = 0; k < scene->boundary.wall_count; k++) {
    const hc_wall_motion *given = &scene->boundary.walls[k].motion;
    if (given->type == HC_WALL_STANDS) continue;
    *wall = (hc_mover){.wall = k, .motion = motion_of(given, next)};
    wall->reach = hc_prescribed_reach(&plan->frame, &plan->boundary[k], wall->motion.centre);
    next += wall->motion.row_count;
    wall++;
  }
  for (int k = 0; k < scene->body_count; k++, wall++) {
    const int number = scene->boundary.wall_count + k;
    const hc_setup_source *const source = &plan->boundary[number];
    *wall = (hc_mover){.wall = number, .motion = {.law = HC_MOTION_BODY}};
    memcpy(wall->motion.centre, source->start.to, sizeof wall->motion.centre);
    wall->reach = hc_prescribed_reach(&plan->frame, source, source->start.from);
  }
  return made;
}

void hc_prescribed_sweep(const hc_motion *motion, double until, double low[3], double high[3]) {
  double shift_low[3], shift_high[3];
  hc_motion_range(motion, until, shift_low, shift_high);
  double square = 0.0;
  for (int a = 0; a < 3; a++) {
    const double farthest = fmax(fabs(low[a] - motion->centre[a]), fabs(high[a] - motion->centre[a]));
    square += farthest * farthest;
  }
  for (int a = 0; a < 3; a++) {
    if (hc_motion_turns(motion)) {
      low[a] = fmin(low[a], motion->centre[a] - sqrt(square));
      high[a] = fmax(high[a], motion->centre[a] + sqrt(square));
    }
    low[a] += shift_low[a];
    high[a] += shift_high[a];
  }
}

double hc_prescribed_speed(const hc_movers *motions, const hc_emitters *emitters, double time, double ahead) {
  double largest = hc_emitters_speed(emitters, time, ahead);
  for (int k = 0; k < motions->count; k++)
    largest = fmax(largest, hc_mover_speed(&motions->walls[k], time, ahead));
  return largest;
}

/* ---- emitters ---- */

hc_source_name hc_prescribed_emitter_name(int number) {
  hc_source_name name;
  snprintf(name.text, sizeof name.text, "fluid.emitters[%d]", number);
  return name;
}

static hc_status check_place(const hc_scene *scene, const hc_emitter *emitter, const char *name,
                             hc_error *error) {
  const double farthest = 0x1p31 * scene->support_radius;
  double low[3], high[3];
  hc_prescribed_emitter_bounds(emitter, low, high);
  for (int a = 0; a < 3; a++)
    if (!(low[a] >= -farthest && high[a] <= farthest))
      return hc_error_set(error, HC_BAD_INPUT,
                          "%s: must lie within 2^31 support radii of the origin, got %g to %g m along %c",
                          name, low[a], high[a], "xyz"[a]);
  return HC_OK;
}

static hc_status make_emitter(const hc_scene *scene, const hc_frame *frame, int number, hc_emitter *emitter,
                              hc_error *error) {
  const hc_scene_emitter *given = &scene->fluid.emitters[number];
  const hc_source_name name = hc_prescribed_emitter_name(number);
  const bool disc = given->form == HC_EMITTER_DISC;
  const double disc_size[2] = {2 * given->radius, 2 * given->radius};
  const double spacing = (double)frame->spacing[0] * frame->unit[0];
  *emitter = (hc_emitter){
      .shape = hc_shape_rectangle(given->position, given->direction, disc ? disc_size : given->size),
      .start = given->start,
      .stop = given->stop > 0.0 ? given->stop : INFINITY,
      .spacing = spacing,
      .clearance = given->clearance * spacing,
      .limit = given->max_particles > 0 ? given->max_particles : INT64_MAX,
      .source = (uint64_t)(scene->fluid.block_count + number)};
  if (!(disc ? hc_emitter_sample_disc(emitter, given->radius) : hc_emitter_sample_rectangle(emitter)))
    return hc_error_set(error, HC_BAD_INPUT, "%s: a layer must have at most 2^24 particles", name.text);
  if (emitter->sample_count == 0)
    return hc_error_set(error, HC_BAD_INPUT,
                        "%s: the opening must have room for a particle, at least %g m across", name.text,
                        disc ? sqrt(2.0) * spacing : spacing);
  if (check_place(scene, emitter, name.text, error) != HC_OK) return error->status;
  /* The area that a layer fills counts, so that the rate is right whatever the lattice leaves out. */
  emitter->speed =
      given->speed > 0.0 ? given->speed : given->rate / ((double)emitter->sample_count * spacing * spacing);
  const double samples = hc_emitter_layers_until(emitter, scene->end_time) * (double)emitter->sample_count;
  if (!(samples <= (double)HC_ID_MAX_COUNTER))
    return hc_error_set(error, HC_BAD_INPUT, "%s: must bring at most 2^%d particles until end_time, not %.3g",
                        name.text, HC_ID_COUNTER_BITS, samples);
  return HC_OK;
}

hc_status hc_prescribed_emitters_make(const hc_scene *scene, const hc_frame *frame, hc_emitters *emitters,
                                      hc_error *error) {
  const int count = scene->fluid.emitter_count;
  *emitters = (hc_emitters){.emitters = hc_alloc_zero((size_t)count, sizeof(hc_emitter)), .count = count};
  if (scene->fluid.block_count + count > HC_ID_MAX_SOURCES)
    return hc_error_set(
        error, HC_BAD_INPUT,
        "fluid.blocks and fluid.emitters must have at most 2^%d entries together, got %d and %d",
        HC_ID_SOURCE_BITS, scene->fluid.block_count, count);
  for (int k = 0; k < count; k++)
    if (make_emitter(scene, frame, k, &emitters->emitters[k], error) != HC_OK) return error->status;
  return HC_OK;
}

void hc_prescribed_emitter_bounds(const hc_emitter *emitter, double low[3], double high[3]) {
  for (int a = 0; a < 3; a++) {
    low[a] = INFINITY;
    high[a] = -INFINITY;
  }
  for (int64_t k = 0; k < emitter->sample_count; k++)
    for (int layer = 0; layer < 2; layer++) {
      double x[3];
      hc_emitter_point(emitter, k, layer * emitter->spacing, x);
      for (int a = 0; a < 3; a++) {
        low[a] = fmin(low[a], x[a]);
        high[a] = fmax(high[a], x[a]);
      }
    }
}
