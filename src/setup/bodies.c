#include "bodies.h"

#include "base/memory.h"
#include "geometry/solid.h"
#include "geometry/vector.h"
#include "setup/carve.h"
#include "setup/controls.h"
#include "setup/prescribed.h"
#include "setup/trace.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- what follows from shapes ---- */

static bool is_made(const hc_wall *surface) {
  return (surface->form != HC_FORM_MESH && surface->form != HC_FORM_REVOLUTION) || surface->made.surface;
}

static void complete(hc_scene_body *body, const hc_given *given) {
  const hc_shape shape = hc_source_wall_shape(&body->surface);
  const hc_solid solid = hc_solid_of(&shape);
  if (!hc_given_has(given, "center_of_mass"))
    memcpy(body->center_of_mass, solid.centre, sizeof body->center_of_mass);
  if (!hc_given_has(given, "position")) memcpy(body->position, body->center_of_mass, sizeof body->position);
  const hc_given_value *const forces = hc_given_value_of(given, "forces");
  const hc_given_value *const moorings = hc_given_value_of(given, "moorings");
  for (int k = 0; k < body->force_count; k++)
    if (!hc_given_has(&forces->items[k], "at"))
      memcpy(body->forces[k].at, body->position, sizeof body->position);
  for (int k = 0; k < body->mooring_count; k++) {
    hc_scene_mooring *const mooring = &body->moorings[k];
    if (!hc_given_has(&moorings->items[k], "at")) memcpy(mooring->at, body->position, sizeof body->position);
    double along[3];
    hc_vector_minus(mooring->anchor, mooring->at, along);
    if (mooring->length == 0.0) mooring->length = hc_vector_length(along);
  }
}

void hc_setup_bodies_complete(hc_scene *scene, hc_findings *findings) {
  const hc_given_value *const given = hc_given_value_of(findings->given, "bodies");
  for (int k = 0; k < scene->body_count; k++)
    if (!given->items[k].bad && is_made(&scene->bodies[k].surface))
      complete(&scene->bodies[k], &given->items[k]);
}

/* ---- bodies ---- */

/* R I R^T */
static void turn_inertia(const double turn[3][3], const double own[3][3], double density,
                         double turned[3][3]) {
  double half[3][3];
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      half[a][b] = turn[a][0] * own[0][b] + turn[a][1] * own[1][b] + turn[a][2] * own[2][b];
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      turned[a][b] = density * (half[a][0] * turn[b][0] + half[a][1] * turn[b][1] + half[a][2] * turn[b][2]);
}

static void hang(const hc_scene_body *given, hc_body *body) {
  body->pull_count = given->force_count;
  body->mooring_count = given->mooring_count;
  body->pulls = hc_alloc_zero((size_t)given->force_count, sizeof *body->pulls);
  body->moorings = hc_alloc_zero((size_t)given->mooring_count, sizeof *body->moorings);
  for (int k = 0; k < given->force_count; k++) {
    const hc_scene_force *const from = &given->forces[k];
    hc_pull *const pull = &body->pulls[k];
    *pull = (hc_pull){.turns = from->frame == HC_FORCE_BODY,
                      .start = from->start,
                      .stop = from->stop > 0.0 ? from->stop : INFINITY};
    memcpy(pull->force, from->force, sizeof pull->force);
    hc_vector_minus(from->at, given->position, pull->arm);
  }
  for (int k = 0; k < given->mooring_count; k++) {
    const hc_scene_mooring *const from = &given->moorings[k];
    hc_mooring *const mooring = &body->moorings[k];
    *mooring = (hc_mooring){.length = from->length,
                            .stiffness = from->stiffness,
                            .damping = from->damping,
                            .pushes = from->type == HC_MOORING_SPRING};
    memcpy(mooring->anchor, from->anchor, sizeof mooring->anchor);
    hc_vector_minus(from->at, given->position, mooring->arm);
  }
}

/* Mass, and inertia as it starts. */
static void weigh(const hc_scene_body *given, const hc_setup_source *source, hc_body *body) {
  const hc_solid solid = hc_solid_of(&source->shape);
  const double density = given->mass > 0.0 ? given->mass / solid.volume : given->density;
  double inertia[3][3];
  body->mass = density * solid.volume;
  memcpy(inertia, solid.inertia, sizeof inertia);
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3 && given->gyration[0] > 0.0; b++)
      inertia[a][b] = a == b ? solid.volume * given->gyration[a] * given->gyration[a] : 0.0;
  turn_inertia(source->start.turn, inertia, density, body->inertia);
}

static void make(const hc_scene_body *given, const hc_setup_source *source, const hc_frame *frame,
                 hc_body *body) {
  *body = (hc_body){.wall = (int)source->number,
                    .locked = given->locked,
                    .friction = given->friction,
                    .restitution = given->restitution,
                    .turn = {1.0, 0.0, 0.0, 0.0}};
  weigh(given, source, body);
  hang(given, body);
  body->reach = fmax(hc_prescribed_reach(frame, source, source->start.from), hc_trace_spacing(frame));
  for (int a = 0; a < 3; a++) {
    body->centre[a] = given->position[a];
    body->position[a] = hc_frame_to_units(frame, a, given->position[a]);
    if (!(given->locked >> a & 1)) body->velocity[a] = given->velocity[a];
  }
  for (int a = 0; a < 3; a++)
    if (!(given->locked >> (3 + a) & 1))
      for (int b = 0; b < 3; b++)
        if (!(given->locked >> (3 + b) & 1))
          body->momentum[a] += body->inertia[a][b] * given->angular_velocity[b];
}

/* ---- what cannot be ---- */

typedef struct path {
  char text[32];
} path;

static path path_of(int number) {
  path path;
  snprintf(path.text, sizeof path.text, "bodies[%d]", number);
  return path;
}

/* A body and what it may meet. */
typedef struct meeting {
  const hc_frame *frame;
  const hc_setup_source *body, *other; /* null other: the containers, none of which holds it */
  const hc_setup_source *walls;
  int wall_count;
  double room; /* m */
  bool found;
  double x[3];
} meeting;

/* Where a point of the shape is as the body starts. */
static void place(const hc_setup_source *body, const double x[3], double at[3]) {
  for (int a = 0; a < 3; a++) at[a] = x[a] - body->start.from[a];
  hc_source_turn(body, at);
  for (int a = 0; a < 3; a++) at[a] += body->start.to[a];
}

/* How far a sample of the body, at x in the shape, is off what the body must keep out of. */
static double clearance(const void *context, const double x[3]) {
  const meeting *const m = context;
  double at[3];
  place(m->body, x, at);
  if (m->other && m->other->start.moved) return hc_carve_distance(m->frame, m->other, at) - m->room;
  if (m->other) return hc_trace_distance(m->frame, hc_shape_distance, &m->other->shape, at) - m->room;
  double nearest = INFINITY;
  for (int w = 0; w < m->wall_count; w++)
    if (!m->walls[w].solid)
      nearest = fmin(nearest, hc_trace_distance(m->frame, hc_shape_region_distance, &m->walls[w].shape, at));
  return nearest == INFINITY ? INFINITY : -nearest - m->room;
}

static bool note_first(void *context, int64_t k, const int64_t point[3], const double x[3]) {
  (void)k, (void)point;
  meeting *const m = context;
  m->found = true;
  place(m->body, x, m->x);
  return false;
}

/* Samples lie half a spacing inside the surface, or in the middle of what is thin. */
static void look(meeting *m) {
  const hc_sampling *const sampling = &m->body->sampling;
  const hc_trace trace = {m, clearance, note_first};
  m->found = false;
  if (sampling->listed) /* of surfaces this rank's share */
    hc_trace_part(m->frame, sampling, sampling->listed_first, sampling->listed_end, &trace);
  else
    hc_trace_run(m->frame, sampling, &trace);
}

static void review_size(const hc_scene *scene, const hc_setup_source *body, int number,
                        hc_findings *findings) {
  static const double LEAST = 0.9, MOST = 0x1p31; /* spacings, as of walls; particles that give way */
  const hc_solid solid = hc_solid_of(&body->shape);
  const double thickness = hc_source_thickness(body);
  const double cube = scene->particle_spacing * scene->particle_spacing * scene->particle_spacing;
  if (!(solid.volume <= MOST * cube)) {
    hc_findings_error(findings, path_of(number).text,
                      "%s must take the place of at most 2^31 particles, not of %.3g",
                      hc_source_body_name(&scene->bodies[number], number).text, solid.volume / cube);
    return;
  }
  if (solid.volume > 0.0 && thickness >= LEAST * scene->particle_spacing) return;
  hc_findings_error(findings, path_of(number).text,
                    "%s must have a volume and be about particle_spacing (%g m) thick, not %g m3 and %g m",
                    hc_source_body_name(&scene->bodies[number], number).text, scene->particle_spacing,
                    solid.volume, thickness);
}

/* Moorings pull by where the body is as a step begins: one that is too light for the step swings ever wider.
 */
static void review_moorings(const hc_scene *scene, const hc_setup_source *source, int number,
                            hc_findings *findings) {
  const hc_scene_body *const body = &scene->bodies[number];
  if (body->mooring_count == 0) return;
  const double longest = hc_setup_control_longest(scene);
  hc_body weighed;
  weigh(body, source, &weighed);
  double least = INFINITY;
  for (int a = 0; a < 3; a++) least = fmin(least, weighed.inertia[a][a]);
  for (int k = 0; k < body->mooring_count; k++) {
    const hc_scene_mooring *const mooring = &body->moorings[k];
    double arm[3];
    hc_vector_minus(mooring->at, body->position, arm);
    const double yields = 1.0 / weighed.mass + hc_vector_dot(arm, arm) / least;
    const double stiffness = longest * longest * yields * mooring->stiffness,
                 damping = longest * yields * mooring->damping;
    if (stiffness <= 1.0 && damping <= 1.0) continue;
    hc_findings_error(
        findings, path_of(number).text,
        "%s.moorings[%d] is too %s for its mass: with steps of up to %.3g s (time_step.max) its %s "
        "must be at most %.4g",
        path_of(number).text, k, stiffness > 1.0 ? "stiff" : "damped", longest,
        stiffness > 1.0 ? "stiffness" : "damping",
        stiffness > 1.0 ? mooring->stiffness / stiffness : mooring->damping / damping);
  }
}

/* Arms from the centre of mass go to the nearest image. */
static void review_period(const hc_scene *scene, const hc_frame *frame, const hc_setup_source *body,
                          int number, hc_findings *findings) {
  const double reach = hc_prescribed_reach(frame, body, body->start.from);
  for (int a = 0; a < 3; a++) {
    const double period = (double)frame->period[a] * frame->unit[a];
    if (period == 0.0 || reach < 0.5 * period) continue;
    hc_findings_error(
        findings, path_of(number).text,
        "%s must reach less far from its centre of mass, %.6g m, than half the period along %c, "
        "%.6g m",
        hc_source_body_name(&scene->bodies[number], number).text, reach, "xyz"[a], 0.5 * period);
    return;
  }
}

static void review_meetings(const hc_scene *scene, const hc_frame *frame, const hc_setup_source *sources,
                            int number, hc_findings *findings) {
  static const double LEAST = 0.25; /* spacings between a sample and another surface */
  const int walls = scene->boundary.wall_count;
  const hc_setup_source *const body = &sources[walls + number];
  const hc_source_name name = hc_source_body_name(&scene->bodies[number], number);
  meeting m = {.frame = frame,
               .body = body,
               .walls = sources,
               .wall_count = walls,
               .room = LEAST * hc_trace_spacing(frame)};
  for (int k = 0; k < walls + number; k++) {
    if (!sources[k].solid) continue;
    m.other = &sources[k];
    look(&m);
    if (!m.found) { /* one may lie within the other */
      m.body = &sources[k];
      m.other = body;
      look(&m);
      m.body = body;
    }
    if (!m.found) continue;
    hc_findings_error(findings, path_of(number).text, "%s must not overlap %s, as at (%.6g, %.6g, %.6g) m",
                      name.text, hc_source_surface_name(scene, k).text, m.x[0], m.x[1], m.x[2]);
    return;
  }
  m.other = NULL;
  look(&m);
  if (m.found)
    hc_findings_error(findings, path_of(number).text,
                      "%s must start within the containers of the scene or above their open faces, not "
                      "reach (%.6g, %.6g, %.6g) m",
                      name.text, m.x[0], m.x[1], m.x[2]);
}

void hc_setup_bodies_review(const hc_scene *scene, const hc_frame *frame, hc_findings *findings) {
  const int count = hc_scene_surfaces(scene);
  if (scene->body_count == 0) return;
  hc_setup_source *const sources = hc_alloc((size_t)count, sizeof *sources);
  int made = 0;
  hc_error error;
  bool good = true;
  for (; made < count; made++) {
    if (hc_source_surface(frame, scene, made, hc_setup_layers(scene), &sources[made], &error) == HC_OK)
      continue;
    good = false;
    if (hc_scene_is_body(scene, made))
      hc_findings_error(findings, path_of(made - scene->boundary.wall_count).text, "%s", error.text);
  }
  for (int k = 0; k < scene->body_count && good; k++) {
    review_size(scene, &sources[scene->boundary.wall_count + k], k, findings);
    review_period(scene, frame, &sources[scene->boundary.wall_count + k], k, findings);
    review_meetings(scene, frame, sources, k, findings);
    review_moorings(scene, &sources[scene->boundary.wall_count + k], k, findings);
  }
  for (int k = 0; k < made; k++) hc_source_free(&sources[k]);
  hc_free(sources);
}

hc_bodies hc_setup_bodies_make(const hc_scene *scene, const hc_setup_plan *plan, const hc_frame *frame) {
  hc_bodies bodies;
  hc_bodies_init(&bodies, scene->body_count, frame);
  bodies.first = scene->boundary.wall_count;
  memcpy(bodies.gravity, scene->gravity, sizeof bodies.gravity);
  memcpy(bodies.pole, scene->central_force.center, sizeof bodies.pole);
  bodies.central_rate = scene->central_force.rate;
  for (int k = 0; k < scene->body_count; k++)
    make(&scene->bodies[k], &plan->boundary[bodies.first + k], frame, &bodies.body[k]);
  return bodies;
}
