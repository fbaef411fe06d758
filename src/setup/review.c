#include "review.h"

#include "base/memory.h"
#include "geometry/surface.h"
#include "setup/bodies.h"
#include "setup/controls.h"
#include "setup/limits.h"
#include "setup/prescribed.h"
#include "setup/source.h"
#include "setup/trace.h"
#include "setup/world_frame.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double slack = 1e-3;   /* spacings: decimal fractions touch, they do not overlap */
static const double upward = 0.7;   /* cosine of what counts as a top */
static const double blocked = 0.75; /* spacings between a ray and the samples that stop it */

typedef struct review {
  const hc_scene *scene;
  hc_findings *findings;
  hc_frame frame;
  double spacing; /* m */
  hc_setup_source *blocks, *walls;
  hc_box *bounds; /* of the blocks */
  int block_count, wall_count;
} review;

/* Looks for particles of a block that meet something. */
typedef struct meeting {
  const review *review;
  const hc_setup_source *other;  /* a block or wall */
  const hc_setup_source *within; /* only what is in this block, too; null: all */
  hc_shape face;                 /* an open one */
  bool found;
  double x[3]; /* the first particle found */
} meeting;

typedef struct path {
  char text[64];
} path;

static path path_of(const char *list, int64_t index, const char *key) {
  path made;
  snprintf(made.text, sizeof made.text, "%s[%lld]%s", list, (long long)index, key);
  return made;
}

static double distance(const review *r, double (*function)(const hc_shape *, const double[3]),
                       const hc_shape *shape, const double x[3]) {
  return hc_trace_distance(&r->frame, function, shape, x);
}

static bool note_first(void *context, int64_t k, const int64_t point[3], const double x[3]) {
  (void)k;
  (void)point;
  meeting *const m = context;
  m->found = true;
  memcpy(m->x, x, sizeof m->x);
  return false;
}

static bool meets(meeting *m, const hc_setup_source *block,
                  double (*clearance)(const void *context, const double x[3])) {
  m->found = false;
  hc_trace_run(&m->review->frame, &block->sampling, &(hc_trace){m, clearance, note_first});
  return m->found;
}

static double clearance_of_wall(const void *context, const double x[3]) {
  const meeting *const m = context;
  const review *const r = m->review;
  const double samples = hc_source_layer_distance(&r->frame, m->other, x) - 0.5 * r->spacing;
  const double solid = m->other->solid ? distance(r, hc_shape_distance, &m->other->shape, x) : INFINITY;
  return fmin(samples, solid) + slack * r->spacing;
}

static double clearance_of_block(const void *context, const double x[3]) {
  const meeting *const m = context;
  double off = distance(m->review, hc_shape_distance, &m->other->shape, x);
  if (m->within) off = fmax(off, distance(m->review, hc_shape_distance, &m->within->shape, x));
  return off + slack * m->review->spacing;
}

/* Of the outside of all containers. */
static double clearance_of_outside(const void *context, const double x[3]) {
  const review *const r = ((const meeting *)context)->review;
  double nearest = INFINITY;
  for (int w = 0; w < r->wall_count; w++)
    if (!r->walls[w].solid)
      nearest = fmin(nearest, distance(r, hc_shape_region_distance, &r->walls[w].shape, x));
  return slack * r->spacing - nearest;
}

static bool far_apart(const review *r, const hc_shape *shape, const hc_setup_source *block, double margin) {
  return distance(r, hc_shape_distance, shape, block->shape.centre) > hc_shape_reach(&block->shape) + margin;
}

/* Beyond all layers of the wall, and inside of it too. */
static bool far_from_wall(const review *r, const hc_setup_source *wall, const hc_setup_source *block) {
  const double *const centre = block->shape.centre, reach = hc_shape_reach(&block->shape) + r->spacing;
  if (wall->solid && distance(r, hc_shape_distance, &wall->shape, centre) <= reach) return false;
  return hc_source_layer_distance(&r->frame, wall, centre) > reach;
}

/* A block that fits itself to what it meets. */
static bool is_rest_state(const hc_setup_source *block) {
  return block->sampling.tile.at != NULL;
}

/* --- Errors --- */

/* A box is filled with whole spacings; what is left over stays empty. */
static void review_rest(const review *r, const hc_setup_source *block) {
  const hc_shape *const shape = &block->shape;
  if (shape->round > 1) return;
  for (int c = 0; c < hc_shape_components(shape); c++) {
    const double extent = shape->high[c] - shape->low[c], count = extent / r->spacing,
                 filled = floor(count + 0.05);
    if (count - filled <= 0.1) continue;
    hc_findings_warning(r->findings, path_of("fluid.blocks", block->number, "").text,
                        "%s is %.6g m along %c, %.2f spacings: %.0f are filled, %.3g m stay empty",
                        hc_source_block_name((int)block->number).text, extent, "xyz"[c], count, filled,
                        extent - filled * r->spacing);
  }
}

static void review_size(const review *r, const hc_setup_source *block) {
  if (hc_source_count(block) > 0) {
    if (!is_rest_state(block)) review_rest(r, block);
    return;
  }
  hc_findings_error(r->findings, path_of("fluid.blocks", block->number, "").text,
                    "%s must be thick enough for a particle, at least particle_spacing (%g m), not %g m",
                    hc_source_block_name((int)block->number).text, r->scene->particle_spacing,
                    hc_source_thickness(block));
}

static bool review_wall(const review *r, const hc_setup_source *block, const hc_setup_source *wall) {
  if (hc_sampling_count(&wall->sampling) == 0 || far_from_wall(r, wall, block)) return false;
  meeting m = {.review = r, .other = wall};
  if (!meets(&m, block, clearance_of_wall)) return false;
  const int number = (int)wall->number;
  hc_findings_error(r->findings, path_of("fluid.blocks", block->number, "").text,
                    "%s must %s %s: a particle would start at (%.6g, %.6g, %.6g) m, %s its surface",
                    hc_source_block_name((int)block->number).text,
                    wall->solid ? "stay out of" : "not reach into",
                    hc_source_wall_name(&r->scene->boundary.walls[number], number).text, m.x[0], m.x[1],
                    m.x[2], wall->solid ? "within" : "behind");
  return true;
}

static void review_walls(const review *r, const hc_setup_source *block) {
  bool reported = false, contained = true;
  for (int w = 0; w < r->wall_count; w++) {
    reported |= review_wall(r, block, &r->walls[w]);
    contained &= r->walls[w].solid;
  }
  meeting m = {.review = r};
  if (reported || contained || !meets(&m, block, clearance_of_outside)) return;
  hc_findings_error(r->findings, path_of("fluid.blocks", block->number, "").text,
                    "%s must lie within the containers of the scene or above their open faces: a particle "
                    "would start at (%.6g, %.6g, %.6g) m, outside of all walls",
                    hc_source_block_name((int)block->number).text, m.x[0], m.x[1], m.x[2]);
}

/* Of thousands of blocks most keep apart along an axis that does not repeat. */
static bool boxes_apart(const review *r, const hc_box *a, const hc_box *b) {
  for (int axis = 0; axis < 3; axis++)
    if (r->frame.period[axis] == 0 && (a->min[axis] >= b->max[axis] || b->min[axis] >= a->max[axis]))
      return true;
  return false;
}

static void review_overlap(const review *r, const hc_setup_source *earlier, const hc_setup_source *later) {
  if (far_apart(r, &earlier->shape, later, 0) || far_apart(r, &later->shape, earlier, 0)) return;
  if (r->scene->fluid.blocks[earlier->number].start != r->scene->fluid.blocks[later->number].start) return;
  const bool fits = is_rest_state(earlier) || is_rest_state(later); /* rest states keep out of other fluid */
  if (fits && !(is_rest_state(earlier) && is_rest_state(later))) return;
  meeting in_later = {.review = r, .other = later, .within = fits ? earlier : NULL},
          in_earlier = {.review = r, .other = earlier, .within = fits ? later : NULL};
  const meeting *found = NULL;
  if (meets(&in_earlier, later, clearance_of_block))
    found = &in_earlier;
  else if (meets(&in_later, earlier, clearance_of_block))
    found = &in_later;
  if (!found) return;
  hc_findings_error(r->findings, path_of("fluid.blocks", later->number, "").text,
                    "%s must not overlap %s: a particle would start at (%.6g, %.6g, %.6g) m, within both",
                    hc_source_block_name((int)later->number).text,
                    hc_source_block_name((int)earlier->number).text, found->x[0], found->x[1], found->x[2]);
}

/* --- Warnings --- */

/* At the face, on the container's side of it. */
static double clearance_of_face(const void *context, const double x[3]) {
  const meeting *const m = context;
  const review *const r = m->review;
  const double face = distance(r, hc_shape_surface_distance, &m->face, x) - r->spacing;
  return fmax(face, distance(r, hc_shape_distance, &m->other->shape, x) - slack * r->spacing);
}

/* Whether a ray from `x` meets a wall other than `own`. */
static bool is_blocked(const review *r, const hc_setup_source *own, const double x[3], const double ray[3]) {
  double end = 0;
  for (int w = 0; w < r->wall_count; w++) {
    const double *const c = r->walls[w].shape.centre;
    const double away =
        sqrt((c[0] - x[0]) * (c[0] - x[0]) + (c[1] - x[1]) * (c[1] - x[1]) + (c[2] - x[2]) * (c[2] - x[2]));
    end = fmax(end, away + hc_source_layer_reach(&r->walls[w]));
  }
  for (double along = 0; along <= end;) {
    const double at[3] = {x[0] + along * ray[0], x[1] + along * ray[1], x[2] + along * ray[2]};
    double nearest = INFINITY;
    for (int w = 0; w < r->wall_count; w++)
      if (&r->walls[w] != own) nearest = fmin(nearest, hc_source_layer_distance(&r->frame, &r->walls[w], at));
    if (nearest < blocked * r->spacing) return true;
    along += nearest - 0.5 * r->spacing;
  }
  return false;
}

/* Whether a face looks neither up nor along a periodic axis. */
static bool may_spill(const review *r, const double normal[3]) {
  double along = 0, square = 0;
  for (int a = 0; a < 3; a++) {
    if (r->frame.period[a] > 0 && fabs(normal[a]) > slack) return false;
    along -= r->scene->gravity[a] * normal[a];
    square += r->scene->gravity[a] * r->scene->gravity[a];
  }
  return square > 0 && along < upward * sqrt(square);
}

static void review_spills(const review *r, const hc_setup_source *block, const hc_setup_source *wall) {
  static const char *const box_faces[] = {"face -x", "face +x", "face -y", "face +y", "face -z", "face +z"};
  static const char *const ends[] = {"", "", "base", "top"};
  const hc_shape *const shape = &wall->shape;
  const int number = (int)wall->number;
  if (wall->solid || r->scene->boundary.walls[number].form == HC_FORM_PLANE || is_rest_state(block)) return;
  if (far_apart(r, shape, block, 0)) return;
  for (int face = shape->round > 1 ? 2 : 0; face < 2 * hc_shape_components(shape); face++) {
    if (!(shape->open >> face & 1)) continue;
    double normal[3];
    hc_shape_face_normal(shape, face, normal);
    if (!may_spill(r, normal)) continue;
    meeting m = {.review = r, .other = wall, .face = *shape};
    m.face.open = ~(1u << face);
    if (!meets(&m, block, clearance_of_face) || is_blocked(r, wall, m.x, normal)) continue;
    hc_findings_warning(
        r->findings, path_of("boundary.walls", wall->number, ".open").text,
        "%s reaches the open %s of %s at (%.6g, %.6g, %.6g) m and no other wall stands behind "
        "it: the fluid runs out at once",
        hc_source_block_name((int)block->number).text, (shape->round > 1 ? ends : box_faces)[face],
        hc_source_wall_name(&r->scene->boundary.walls[number], number).text, m.x[0], m.x[1], m.x[2]);
  }
}

/* --- The scene --- */

/* Each periodic axis for itself, so that all are heard of. */
static bool review_frame(review *r) {
  bool good = true;
  hc_error error;
  for (int a = 0; a < 3; a++) {
    if (!r->scene->domain.periodic[a]) continue;
    hc_scene alone = *r->scene;
    for (int b = 0; b < 3; b++) alone.domain.periodic[b] = b == a;
    if (hc_setup_frame(&alone, &r->frame, &error) == HC_OK) continue;
    hc_findings_error(r->findings, "domain.max", "%s", error.text);
    good = false;
  }
  if (!good) return false;
  if (hc_setup_frame(r->scene, &r->frame, &error) == HC_OK) return true;
  hc_findings_error(r->findings, "", "%s", error.text);
  return false;
}

/* Sources that are refused are said and left out. */
static void make_sources(review *r) {
  hc_error error;
  for (int k = 0; k < r->scene->fluid.block_count; k++) {
    hc_setup_source *const block = &r->blocks[r->block_count++];
    if (hc_source_block(&r->frame, &r->scene->fluid.blocks[k], k, block, &error) == HC_OK) continue;
    hc_findings_error(r->findings, path_of("fluid.blocks", k, "").text, "%s", error.text);
    hc_source_free(&r->blocks[--r->block_count]);
  }
  for (int k = 0; k < r->scene->boundary.wall_count; k++) {
    hc_setup_source *const wall = &r->walls[r->wall_count++];
    const int layers = hc_setup_layers(r->scene);
    if (hc_source_wall(&r->frame, &r->scene->boundary.walls[k], k, layers, wall, &error) == HC_OK) continue;
    hc_findings_error(r->findings, path_of("boundary.walls", k, "").text, "%s", error.text);
    hc_source_free(&r->walls[--r->wall_count]);
  }
}

/* --- Gauges --- */

typedef struct extent {
  double low[3], high[3]; /* m */
} extent;

static void widen(const review *r, const hc_setup_source *source, extent *to) {
  if (hc_sampling_count(&source->sampling) == 0) return;
  int64_t low[3], high[3];
  hc_sampling_bounds(&source->sampling, low, high);
  for (int a = 0; a < 3; a++) {
    to->low[a] = fmin(to->low[a], hc_frame_to_metres(&r->frame, a, low[a]) - r->spacing);
    to->high[a] = fmax(to->high[a], hc_frame_to_metres(&r->frame, a, high[a]) + r->spacing);
  }
}

static const extent nothing = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

/* Does a height's line go through all coordinates along that axis? */
static bool is_along(const hc_scene *scene, const hc_scene_gauge *gauge, int axis) {
  if (gauge->type != HC_GAUGE_HEIGHT) return false;
  if (gauge->axis) return gauge->axis >> (2 * axis) & (HC_FACE_MINUS_X | HC_FACE_PLUS_X);
  const double *const g = scene->gravity;
  return g[axis] != 0 || (axis == 2 && g[0] == 0 && g[1] == 0);
}

/* A gauge that never measures anything: a point, or a box, away from its wall or from wherever fluid can
 * come. */
static void review_gauge(const review *r, int index, const extent *all) {
  const hc_scene_gauge *gauge = &r->scene->output.gauges[index];
  const bool at_point = gauge->type == HC_GAUGE_HEIGHT || gauge->type == HC_GAUGE_PRESSURE;
  if (gauge->type == HC_GAUGE_FORCE) return;
  extent within = *all;
  for (int w = 0; at_point && w < r->wall_count; w++) {
    const int64_t number = r->walls[w].number;
    if (strcmp(r->scene->boundary.walls[number].name, gauge->wall) != 0) continue;
    within = nothing;
    widen(r, &r->walls[w], &within);
  }
  const double *low = at_point ? gauge->at : gauge->box.min, *high = at_point ? gauge->at : gauge->box.max;
  for (int a = 0; a < 3; a++) {
    if (r->frame.period[a] > 0 || is_along(r->scene, gauge, a)) continue;
    if (low[a] <= within.high[a] && high[a] >= within.low[a]) continue;
    hc_findings_error(r->findings, path_of("output.gauges", index, at_point ? ".at" : ".box.min").text,
                      "gauge %s measures nothing: along %c it is at %.6g%s, and %s only from %.6g to %.6g m",
                      gauge->name, "xyz"[a], low[a], at_point ? "" : " and beyond",
                      gauge->wall[0] && at_point ? "its wall reaches" : "fluid can be", within.low[a],
                      within.high[a]);
    return;
  }
}

/* Wherever fluid can come: within domain.limits; where the scene gives none, at most HC_LIMITS_ROOM longest
 * edges from all that there is, and anywhere without walls, with emitters, or where walls move. */
static extent find_world(const review *r) {
  extent all = nothing;
  bool bounded = r->wall_count > 0 && r->scene->fluid.emitter_count == 0;
  for (int b = 0; b < r->block_count; b++) widen(r, &r->blocks[b], &all);
  for (int w = 0; w < r->wall_count; w++) {
    widen(r, &r->walls[w], &all);
    bounded &= r->scene->boundary.walls[r->walls[w].number].motion.type == HC_WALL_STANDS;
  }
  double edge = 0;
  for (int a = 0; a < 3; a++) edge = fmax(edge, all.high[a] - all.low[a]);
  for (int a = 0; a < 3; a++) {
    const double low = r->scene->domain.limits_min[a], high = r->scene->domain.limits_max[a];
    const bool given = high > low, open = !(bounded || given);
    all.low[a] = open ? -INFINITY : given ? low : all.low[a] - HC_LIMITS_ROOM * edge;
    all.high[a] = open ? INFINITY : given ? high : all.high[a] + HC_LIMITS_ROOM * edge;
  }
  return all;
}

static void review_gauges(const review *r) {
  const extent all = find_world(r);
  for (int k = 0; k < r->scene->output.gauge_count; k++) review_gauge(r, k, &all);
}

/* --- Emitters --- */

/* A sample of an emitter that comes in where a wall's samples are. */
static bool review_opening(const review *r, int number, const hc_emitter *emitter,
                           const hc_setup_source *wall) {
  for (int64_t k = 0; k < emitter->sample_count; k++) {
    double x[3];
    hc_emitter_point(emitter, k, 0.0, x);
    if (hc_source_layer_distance(&r->frame, wall, x) >= 0.5 * r->spacing) continue;
    hc_findings_warning(
        r->findings, path_of("fluid.emitters", number, "").text,
        "%s comes within half a spacing of %s: a particle would start at (%.6g, %.6g, %.6g) m",
        hc_prescribed_emitter_name(number).text,
        hc_source_wall_name(&r->scene->boundary.walls[wall->number], (int)wall->number).text, x[0], x[1],
        x[2]);
    return true;
  }
  return false;
}

/* A sample of an emitter that comes in where a block of fluid is. */
static bool review_flood(const review *r, int number, const hc_emitter *emitter,
                         const hc_setup_source *block) {
  for (int64_t k = 0; k < emitter->sample_count; k++) {
    double x[3];
    hc_emitter_point(emitter, k, 0.0, x);
    if (distance(r, hc_shape_distance, &block->shape, x) >= 0.0) continue;
    hc_findings_warning(
        r->findings, path_of("fluid.emitters", number, "").text,
        "%s opens within %s, at (%.6g, %.6g, %.6g) m: what finds fluid in its place is left out",
        hc_prescribed_emitter_name(number).text, hc_source_block_name((int)block->number).text, x[0], x[1],
        x[2]);
    return true;
  }
  return false;
}

/* Two openings that would let particles in on top of each other: what comes in within one step is judged by
 * what is there before. Openings that are never open together may share a place. */
static void review_openings(const review *r, const hc_emitters *emitters, int a, int b) {
  const hc_emitter *one = &emitters->emitters[a], *other = &emitters->emitters[b];
  if (one->stop <= other->start || other->stop <= one->start) return;
  const double clearance = fmax(one->clearance, other->clearance);
  for (int64_t k = 0; k < one->sample_count; k++) {
    for (int64_t l = 0; l < other->sample_count; l++) {
      double x[3], y[3], square = 0.0;
      hc_emitter_point(one, k, 0.0, x);
      hc_emitter_point(other, l, 0.0, y);
      for (int axis = 0; axis < 3; axis++) square += (x[axis] - y[axis]) * (x[axis] - y[axis]);
      if (square >= clearance * clearance) continue;
      hc_findings_error(
          r->findings, path_of("fluid.emitters", b, "").text,
          "%s must keep its clearance, %.6g m, from %s: particles would come in on top of each other at "
          "(%.6g, %.6g, %.6g) m",
          hc_prescribed_emitter_name(b).text, clearance, hc_prescribed_emitter_name(a).text, x[0], x[1],
          x[2]);
      return;
    }
  }
}

static void review_emitter(const review *r, int number, const hc_emitter *emitter) {
  for (int w = 0; w < r->wall_count; w++)
    if (review_opening(r, number, emitter, &r->walls[w])) break;
  for (int b = 0; b < r->block_count && emitter->start == 0.0; b++)
    if (review_flood(r, number, emitter, &r->blocks[b])) break;
}

static void review_emitters(const review *r) {
  hc_emitters emitters;
  hc_error error;
  if (hc_prescribed_emitters_make(r->scene, &r->frame, &emitters, &error) != HC_OK)
    hc_findings_error(r->findings, "fluid.emitters", "%s", error.text);
  else
    for (int k = 0; k < emitters.count; k++) {
      review_emitter(r, k, &emitters.emitters[k]);
      for (int earlier = 0; earlier < k; earlier++) review_openings(r, &emitters, earlier, k);
    }
  hc_emitters_free(&emitters);
}

/* What comes later must know where walls are then. */
static void review_refills(const hc_scene *scene, hc_findings *findings) {
  bool moves = false;
  for (int w = 0; w < scene->boundary.wall_count; w++)
    moves |= scene->boundary.walls[w].motion.type != HC_WALL_STANDS;
  for (int k = 0; k < scene->fluid.block_count; k++) {
    const hc_block *const block = &scene->fluid.blocks[k];
    if (block->start > 0.0 && (!block->rest_state[0] || moves))
      hc_findings_error(
          findings, path_of("fluid.blocks", k, ".start").text, "fluid.blocks[%d].start must be 0 %s", k,
          block->rest_state[0] ? "where walls have a prescribed motion"
                               : "without a rest_state: only that fits itself to what is there");
    if (block->replaces && !(block->start > 0.0))
      hc_findings_error(
          findings, path_of("fluid.blocks", k, ".replaces").text,
          "fluid.blocks[%d].replaces must not be true with start 0: there is nothing to replace", k);
  }
}

/* Starts that cannot work, whatever the places. */
static void review_start(const hc_scene *scene, hc_findings *findings) {
  if (scene->solver.negative_pressure && scene->fluid.emitter_count > 0)
    hc_findings_error(
        findings, "solver.negative_pressure",
        "solver.negative_pressure must not be true with fluid.emitters: there is a free surface");
  if (scene->fluid.disorder > 0.0 && scene->fluid.settle_steps == 0)
    hc_findings_warning(findings, "fluid.disorder",
                        "fluid.disorder leaves particles too near to each other, which fly apart, unless "
                        "fluid.settle_steps (50, say) let the start come to rest");
}

void hc_setup_review(const hc_scene *scene, hc_findings *findings) {
  if (scene->fluid.block_count == 0 && scene->fluid.emitter_count == 0)
    hc_findings_error(findings, "fluid.blocks",
                      "fluid.blocks must have at least one block, or fluid.emitters an emitter: there is no "
                      "fluid");
  review_start(scene, findings);
  review_refills(scene, findings);
  review r = {.scene = scene, .findings = findings};
  if (!review_frame(&r)) return;
  r.spacing = hc_trace_spacing(&r.frame);
  r.blocks = hc_alloc((size_t)scene->fluid.block_count, sizeof *r.blocks);
  r.walls = hc_alloc((size_t)scene->boundary.wall_count, sizeof *r.walls);
  make_sources(&r);
  r.bounds = hc_alloc((size_t)r.block_count, sizeof *r.bounds);
  for (int b = 0; b < r.block_count; b++)
    hc_shape_bounds(&r.blocks[b].shape, r.bounds[b].min, r.bounds[b].max);
  review_emitters(&r);
  const bool all_walls = r.wall_count == scene->boundary.wall_count;
  for (int b = 0; b < r.block_count; b++) {
    review_size(&r, &r.blocks[b]);
    if (all_walls && !is_rest_state(&r.blocks[b])) review_walls(&r, &r.blocks[b]);
    for (int earlier = 0; earlier < b; earlier++)
      if (!boxes_apart(&r, &r.bounds[earlier], &r.bounds[b]))
        review_overlap(&r, &r.blocks[earlier], &r.blocks[b]);
    for (int w = 0; w < r.wall_count; w++) review_spills(&r, &r.blocks[b], &r.walls[w]);
  }
  if (r.block_count == scene->fluid.block_count) hc_setup_control_review(scene, findings);
  if (all_walls && r.block_count == scene->fluid.block_count) review_gauges(&r);
  if (all_walls) hc_setup_bodies_review(scene, &r.frame, findings);
  for (int b = 0; b < r.block_count; b++) hc_source_free(&r.blocks[b]);
  for (int w = 0; w < r.wall_count; w++) hc_source_free(&r.walls[w]);
  hc_free(r.blocks);
  hc_free(r.bounds);
  hc_free(r.walls);
}
