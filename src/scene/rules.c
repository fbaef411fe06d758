#include "rules.h"

#include "base/memory.h"
#include "fill.h"
#include "source_rules.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char axes[] = "xyz";

/* A key that other keys make required. */
static void require(const hc_given *given, const char *path, const char *reason, hc_complaints *complaints) {
  if (hc_given_has(given, path) || hc_given_is_bad(given, path)) return;
  hc_complaints_add(complaints, given->place, "missing key '%s%s', required %s", given->prefix, path, reason);
}

/* `max` above `min` along the wanted axes (null: all). */
static void check_box(const hc_given *given, const char *low, const char *high, const double min[3],
                      const double max[3], const bool wanted[3], hc_complaints *complaints) {
  if (hc_given_is_bad(given, low) || hc_given_is_bad(given, high) || !hc_given_has(given, low) ||
      !hc_given_has(given, high))
    return;
  for (int k = 0; k < 3; k++) {
    if ((wanted && !wanted[k]) || max[k] > min[k]) continue;
    char low_text[HC_PARAM_NUMBER_TEXT], high_text[HC_PARAM_NUMBER_TEXT];
    hc_params_number_text(min[k], low_text);
    hc_params_number_text(max[k], high_text);
    hc_complaints_add(complaints, hc_given_place_of(given, high), "%s%s must be > %s along %c, not %s <= %s",
                      given->prefix, high, low, axes[k], high_text, low_text);
  }
}

/* The default output directory is called like the scene, and lies where the runs are. */
static bool names_folder(const char *name) {
  return *name && !strchr(name, '/') && strcmp(name, ".") != 0 && strcmp(name, "..") != 0;
}

static void check_name(const hc_scene *scene, const hc_given *given, hc_complaints *complaints) {
  if (hc_given_is_bad(given, "name") || names_folder(scene->name)) return;
  hc_complaints_add(complaints, hc_given_place_of(given, "name"),
                    "name must do as a folder's name: without '/', not '.' or '..', not '%s'", scene->name);
}

/* The file's name without folder and extension. */
static void name_scene(hc_scene *scene, const char *file_name) {
  const char *slash = strrchr(file_name, '/');
  const char *start = slash ? slash + 1 : file_name;
  const char *dot = strrchr(start, '.');
  size_t length = dot && dot > start ? (size_t)(dot - start) : strlen(start);
  if (length >= sizeof scene->name) length = sizeof scene->name - 1;
  /* A file may be called anything, a scene's name must be text. */
  for (size_t k = 0; k < length;) {
    const int bytes = hc_complaints_character(start + k, length - k);
    if (bytes <= 0 || (unsigned char)start[k] < ' ') {
      scene->name[k++] = '_';
      continue;
    }
    memcpy(scene->name + k, start + k, (size_t)bytes);
    k += (size_t)bytes;
  }
  if (!names_folder(scene->name)) strcpy(scene->name, "scene");
}

static void check_support(hc_scene *scene, const hc_given *given, hc_complaints *complaints) {
  if (hc_given_is_bad(given, "particle_spacing") || hc_given_is_bad(given, "support_radius")) return;
  const double spacing = scene->particle_spacing;
  /* Cubes of it and their inverses must be numbers, in single precision too. */
  if (spacing < 1e-9 || spacing > 1e9) {
    char seen[HC_PARAM_NUMBER_TEXT];
    hc_params_number_text(spacing, seen);
    hc_complaints_add(complaints, hc_given_place_of(given, "particle_spacing"),
                      "particle_spacing must be 1e-9 to 1e9, not %s", seen);
    return;
  }
  if (!hc_given_has(given, "support_radius")) {
    if (hc_given_is_bad(given, "support_ratio")) return;
    scene->support_radius = scene->support_ratio * spacing;
  }
  /* Room for the rounding of decimal fractions: 0.03 is 1.5 spacings of 0.02. */
  const double ratio = scene->support_radius / spacing;
  if (!hc_given_has(given, "support_ratio")) scene->support_ratio = ratio;
  if (ratio >= 1.5 * (1 - 4 * DBL_EPSILON) && ratio <= 4 * (1 + 4 * DBL_EPSILON)) {
    if (fabs(scene->support_ratio - ratio) > 1e-9 * ratio && !hc_given_is_bad(given, "support_ratio"))
      hc_complaints_add(
          complaints, hc_given_place_of(given, "support_radius"),
          "support_radius must be support_ratio particle_spacing, %.9g m, not %.9g: leave one of them out",
          scene->support_ratio * spacing, scene->support_radius);
    return;
  }
  char radius[HC_PARAM_NUMBER_TEXT], times[HC_PARAM_NUMBER_TEXT];
  hc_params_number_text(scene->support_radius, radius);
  hc_params_number_text(ratio, times);
  hc_complaints_add(complaints, hc_given_place_of(given, "support_radius"),
                    "support_radius must be 1.5 to 4 particle_spacing, not %s (%s particle_spacing)", radius,
                    times);
}

static void check_domain(const hc_scene *scene, const hc_given *given, hc_complaints *complaints) {
  const bool *periodic = scene->domain.periodic;
  if (hc_given_is_bad(given, "domain.periodic") || !(periodic[0] || periodic[1] || periodic[2])) return;
  require(given, "domain.min", "along periodic axes", complaints);
  require(given, "domain.max", "along periodic axes", complaints);
  check_box(given, "domain.min", "domain.max", scene->domain.min, scene->domain.max, periodic, complaints);
}

/* Along an axis the limits are given, or both are 0. */
static void check_limits(const hc_scene *scene, const hc_given *given, hc_complaints *complaints) {
  const char *low = "domain.limits.min", *high = "domain.limits.max";
  if (!hc_given_has(given, low) && !hc_given_has(given, high)) return;
  require(given, low, "with domain.limits.max", complaints);
  require(given, high, "with domain.limits.min", complaints);
  const double *min = scene->domain.limits_min, *max = scene->domain.limits_max;
  bool wanted[3];
  for (int k = 0; k < 3; k++) wanted[k] = !scene->domain.periodic[k] && (min[k] != 0.0 || max[k] != 0.0);
  check_box(given, low, high, min, max, wanted, complaints);
}

static void check_iterations(const hc_given *given, const char *low, const char *high,
                             hc_iterations iterations, hc_complaints *complaints) {
  if (hc_given_is_bad(given, low) || hc_given_is_bad(given, high) || iterations.min <= iterations.max) return;
  const char *which = hc_given_has(given, high) ? high : low;
  hc_complaints_add(complaints, hc_given_place_of(given, which), "%s must be <= %s, not %d > %d", low, high,
                    iterations.min, iterations.max);
}

/* False, after a complaint, for a direction of no length. */
static bool check_direction(const hc_given *given, const char *path, const double direction[3],
                            hc_complaints *complaints) {
  if (!hc_given_has(given, path) || hc_given_is_bad(given, path)) return false;
  if (direction[0] != 0.0 || direction[1] != 0.0 || direction[2] != 0.0) return true;
  hc_complaints_add(complaints, hc_given_place_of(given, path), "%s%s must not be zero, not [0, 0, 0]",
                    given->prefix, path);
  return false;
}

static void check_profile(const hc_given *given, const hc_revolution *revolution, hc_complaints *complaints) {
  for (int k = 0; k < revolution->profile_count; k++) {
    const double radius = revolution->profile[k][0];
    if (radius >= 0.0) continue;
    char text[HC_PARAM_NUMBER_TEXT];
    hc_params_number_text(radius, text);
    hc_complaints_add(complaints, hc_given_place_of(given, "revolution.profile"),
                      "%srevolution.profile[%d] must have r >= 0, not %s", given->prefix, k, text);
  }
}

/* What blocks and walls have in common. */
static void check_shape(const hc_given *given, const hc_box *box, const hc_rotation *rotation,
                        const hc_cylinder *cylinder, hc_complaints *complaints) {
  check_box(given, "box.min", "box.max", box->min, box->max, NULL, complaints);
  check_direction(given, "box.rotation.axis", rotation->axis, complaints);
  check_direction(given, "cylinder.axis", cylinder->axis, complaints);
}

static void check_surface(const hc_given *given, const hc_mesh_input *mesh, const hc_revolution *revolution,
                          hc_complaints *complaints) {
  check_direction(given, "mesh.rotation.axis", mesh->rotation.axis, complaints);
  check_direction(given, "revolution.axis", revolution->axis, complaints);
  check_profile(given, revolution, complaints);
}

static void check_block(const hc_block *block, const hc_given *given, hc_complaints *complaints) {
  check_shape(given, &block->box, &block->rotation, &block->cylinder, complaints);
  check_surface(given, &block->mesh, &block->revolution, complaints);
  if (hc_given_is_bad(given, "flow.type") || block->flow.type == HC_FLOW_NONE) return;
  require(given, "flow.speed", "with a flow.type", complaints);
  require(given, "flow.length", "with a flow.type", complaints);
  if (block->flow.type == HC_FLOW_STANDING_WAVE)
    require(given, "flow.depth", "with flow.type standing_wave", complaints);
}

/* To unit length; one that has it already keeps its bits, so that a written scene reads back the same. */
static void normalize(hc_wall *wall, const hc_given *given, hc_complaints *complaints) {
  double *n = wall->normal;
  if (!check_direction(given, "plane.normal", n, complaints)) return;
  const double squared = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
  if (fabs(squared - 1.0) <= 8 * DBL_EPSILON) return;
  /* Scaled first: squares of extreme components would over- or underflow. */
  const double largest = fmax(fabs(n[0]), fmax(fabs(n[1]), fabs(n[2])));
  for (int k = 0; k < 3; k++) n[k] /= largest;
  const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  for (int k = 0; k < 3; k++) n[k] /= length;
}

/* A box has faces, a cylinder ends; one must be left to be a wall. */
static void check_open(const hc_wall *wall, const hc_given *given, hc_complaints *complaints) {
  if (!hc_given_has(given, "open") || hc_given_is_bad(given, "open")) return;
  const bool box = wall->form == HC_FORM_BOX;
  const hc_place place = hc_given_place_of(given, "open");
  if (wall->open & ~(unsigned)(box ? HC_FACES_OF_BOX : HC_FACES_OF_CYLINDER))
    hc_complaints_add(complaints, place, "%sopen must be of %s", given->prefix,
                      box ? "-x, +x, -y, +y, -z, +z with a box, not base or top"
                          : "base, top with a cylinder, not -x, +x, -y, +y, -z or +z");
  else if (wall->open == HC_FACES_OF_BOX)
    hc_complaints_add(complaints, place, "%sopen must leave a face of the box closed, not open all six",
                      given->prefix);
}

static void check_wall(hc_scene *scene, int index, const hc_given *given, hc_complaints *complaints) {
  hc_wall *wall = &scene->boundary.walls[index];
  check_shape(given, &wall->box, &wall->rotation, &wall->cylinder, complaints);
  check_surface(given, &wall->mesh, &wall->revolution, complaints);
  const bool sheet = (wall->form == HC_FORM_MESH && !wall->mesh.closed) ||
                     (wall->form == HC_FORM_REVOLUTION && !wall->revolution.closed);
  if (sheet && hc_given_has(given, "inside") && wall->inside != HC_INSIDE_FLUID)
    hc_complaints_add(complaints, hc_given_place_of(given, "inside"),
                      "%sinside must not be solid: the surface is not closed", given->prefix);
  check_open(wall, given, complaints);
  normalize(wall, given, complaints);
  hc_source_rules_motion(wall, given, complaints);
  if (!hc_given_has(given, "name")) snprintf(wall->name, sizeof wall->name, "wall_%d", index);
}

static void check_body(hc_scene *scene, int index, const hc_given *given, hc_complaints *complaints) {
  hc_scene_body *const body = &scene->bodies[index];
  hc_wall *const surface = &body->surface;
  check_shape(given, &surface->box, &surface->rotation, &surface->cylinder, complaints);
  check_surface(given, &surface->mesh, &surface->revolution, complaints);
  check_direction(given, "rotation.axis", body->turned.axis, complaints);
  surface->inside = HC_INSIDE_SOLID;
  surface->mesh.closed = surface->revolution.closed = true;
  hc_source_rules_body(body, given, complaints);
  if (!hc_given_has(given, "name")) snprintf(surface->name, sizeof surface->name, "body_%d", index);
}

/* The default of the coefficient and its upper end go by the model. */
static void complete_viscosity(hc_scene *scene, const hc_given *given, hc_complaints *complaints) {
  static const double MOST_SPACINGS = 1.0, USUAL = 0.15;
  const char *const key = "fluid.viscosity.coefficient";
  double *const coefficient = &scene->fluid.viscosity.coefficient;
  if (scene->fluid.viscosity.model != HC_VISCOSITY_SMAGORINSKY || hc_given_is_bad(given, key) ||
      hc_given_is_bad(given, "fluid.viscosity.model"))
    return;
  if (!hc_given_has(given, key)) *coefficient = USUAL;
  if (*coefficient <= MOST_SPACINGS) return;
  char text[HC_PARAM_NUMBER_TEXT];
  hc_params_number_text(*coefficient, text);
  hc_complaints_add(complaints, hc_given_place_of(given, key),
                    "%s must be in [0, 1] with model smagorinsky, not %s", key, text);
}

/* What is given of a wall or body, by its number among both. */
static const hc_given *given_surface(const hc_scene *scene, const hc_given *given, int number) {
  const int walls = scene->boundary.wall_count;
  return number < walls ? &hc_given_value_of(given, "boundary.walls")->items[number]
                        : &hc_given_value_of(given, "bodies")->items[number - walls];
}

static void complete_surface(const hc_scene *scene, hc_wall *surface, const hc_given *own,
                             hc_complaints *complaints) {
  if (own->bad || hc_given_is_bad(own, "friction_law")) return;
  if (!hc_given_has(own, "friction_law")) surface->friction_law = scene->boundary.friction_law;
  if (!hc_given_has(own, "roughness")) surface->roughness = scene->boundary.roughness;
  if (surface->friction_law == HC_SCENE_FRICTION_ROUGH && surface->roughness == 0.0)
    require(own, "roughness", "with friction_law rough", complaints);
  if (scene->fluid.viscosity.model == HC_VISCOSITY_LAMINAR &&
      (surface->friction_law == HC_SCENE_FRICTION_NO_SLIP) !=
          (hc_scene_surface(scene, 0)->friction_law == HC_SCENE_FRICTION_NO_SLIP))
    hc_complaints_add(complaints, hc_given_place_of(own, "friction_law"),
                      "%sfriction_law: with laminar viscosity all walls must be no_slip, or none",
                      own->prefix);
}

/* The friction of walls, by what the scene says and else by what goes with its viscosity. */
static void complete_friction(hc_scene *scene, const hc_given *given, hc_complaints *complaints) {
  const bool laminar = scene->fluid.viscosity.model == HC_VISCOSITY_LAMINAR;
  if (hc_given_is_bad(given, "boundary.friction_law") || hc_given_is_bad(given, "fluid.viscosity.model"))
    return;
  if (!hc_given_has(given, "fluid.kinematic_viscosity") && laminar &&
      scene->fluid.viscosity.coefficient > 0.0)
    scene->fluid.kinematic_viscosity = scene->fluid.viscosity.coefficient;
  if (!hc_given_has(given, "boundary.friction_law"))
    scene->boundary.friction_law = laminar                          ? HC_SCENE_FRICTION_NO_SLIP
                                   : scene->boundary.friction < 1.0 ? HC_SCENE_FRICTION_NONE
                                                                    : HC_SCENE_FRICTION_SMOOTH;
  if (scene->boundary.friction_law == HC_SCENE_FRICTION_ROUGH && scene->boundary.roughness == 0.0)
    require(given, "boundary.roughness", "with friction_law rough", complaints);
  for (int k = 0; k < scene->boundary.wall_count; k++)
    complete_surface(scene, &scene->boundary.walls[k], given_surface(scene, given, k), complaints);
  for (int k = 0; k < scene->body_count; k++)
    complete_surface(scene, &scene->bodies[k].surface,
                     given_surface(scene, given, scene->boundary.wall_count + k), complaints);
}

/* A name of a wall or body, by its number among both. */
typedef struct surface_name {
  const char *name;
  int number;
} surface_name;

static int by_name(const void *left, const void *right) {
  const surface_name *const a = left, *const b = right;
  const int order = strcmp(a->name, b->name);
  return order ? order : (a->number > b->number) - (a->number < b->number);
}

static void check_surface_names(const hc_scene *scene, const hc_given *given, hc_complaints *complaints) {
  const int count = hc_scene_surfaces(scene), walls = scene->boundary.wall_count;
  surface_name *const sorted = hc_alloc((size_t)count, sizeof *sorted);
  for (int k = 0; k < count; k++) sorted[k] = (surface_name){hc_scene_surface(scene, k)->name, k};
  qsort(sorted, (size_t)count, sizeof *sorted, by_name);
  for (int k = 1, first = 0; k < count; k++) {
    if (strcmp(sorted[first].name, sorted[k].name) != 0) first = k;
    const hc_given *own = given_surface(scene, given, sorted[k].number);
    const int like = sorted[first].number;
    if (first != k && !own->bad && !hc_given_is_bad(own, "name"))
      hc_complaints_add(complaints, hc_given_place_of(own, "name"),
                        "%sname must be the %s's own, not '%s' like %s %d", own->prefix,
                        sorted[k].number < walls ? "wall" : "body", sorted[k].name,
                        like < walls ? "wall" : "body", like < walls ? like : like - walls);
  }
  hc_free(sorted);
}

static void check_rectangle(const hc_scene_gauge *gauge, const hc_given *given, hc_complaints *complaints) {
  int flat = 0, normal = 0;
  for (int k = 0; k < 3; k++) {
    if (gauge->box.min[k] == gauge->box.max[k]) flat++;
    if (gauge->axis & (HC_FACE_MINUS_X | HC_FACE_PLUS_X) << (2 * k)) normal = k;
  }
  if (flat == 1 && gauge->box.min[normal] == gauge->box.max[normal]) return;
  hc_complaints_add(
      complaints, hc_given_place_of(given, "box.max"),
      "%sbox must be a rectangle across its axis: box.min and box.max equal along %c and nowhere else",
      given->prefix, axes[normal]);
}

/* Would a column of the gauge `name` with several columns be called `other`? */
static bool makes_column(const hc_scene_gauge *gauge, const char *other) {
  const char *const *part = hc_scene_gauge_parts(gauge->type);
  const size_t length = strlen(gauge->name);
  if (strncmp(gauge->name, other, length) != 0 || other[length] != '_') return false;
  for (; *part; part++)
    if (strcmp(other + length + 1, *part) == 0) return true;
  return false;
}

/* The axis that a height's line is nearest to. */
static int height_axis(const hc_scene *scene, const hc_scene_gauge *gauge) {
  int nearest = 2;
  for (int k = 0; k < 3; k++) {
    if (gauge->axis >> (2 * k) & (HC_FACE_MINUS_X | HC_FACE_PLUS_X)) return k;
    if (fabs(scene->gravity[k]) > fabs(scene->gravity[nearest])) nearest = k;
  }
  return nearest;
}

/* Two coordinates are those across a height's line, where it is at 0. */
static void complete_point(const hc_scene *scene, hc_scene_gauge *gauge, const hc_given *given,
                           hc_complaints *complaints) {
  if (!isnan(gauge->at[2])) return;
  gauge->at[2] = 0.0;
  if (gauge->type != HC_GAUGE_HEIGHT) {
    hc_complaints_add(complaints, hc_given_place_of(given, "at"),
                      "%sat must be a list of 3 numbers, not a list of 2", given->prefix);
    return;
  }
  const int axis = height_axis(scene, gauge);
  for (int k = 2; k > axis; k--) gauge->at[k] = gauge->at[k - 1];
  gauge->at[axis] = 0.0;
}

/* Any point of a wall's surface has a sample within a spacing. */
static void check_radius(const hc_scene *scene, const hc_scene_gauge *gauge, const hc_given *given,
                         hc_complaints *complaints) {
  if (gauge->radius == 0.0 || gauge->radius >= scene->particle_spacing || hc_given_is_bad(given, "radius"))
    return;
  char radius[HC_PARAM_NUMBER_TEXT], spacing[HC_PARAM_NUMBER_TEXT];
  hc_params_number_text(gauge->radius, radius);
  hc_params_number_text(scene->particle_spacing, spacing);
  hc_complaints_add(complaints, hc_given_place_of(given, "radius"),
                    "%sradius must be >= particle_spacing, or 0 for the support radius, not %s < %s",
                    given->prefix, radius, spacing);
}

static const hc_scene_body *body_named(const hc_scene *scene, const char *name) {
  const int number = hc_scene_surface_named(scene, name);
  return number >= 0 && hc_scene_is_body(scene, number) ? &scene->bodies[number - scene->boundary.wall_count]
                                                        : NULL;
}

static void check_gauged_body(const hc_scene *scene, const hc_scene_gauge *gauge, const hc_given *given,
                              hc_complaints *complaints) {
  const hc_scene_body *const body = body_named(scene, gauge->body);
  if (!body)
    hc_complaints_add(complaints, hc_given_place_of(given, "body"),
                      "%sbody must be the name of a body of the scene, not '%s'", given->prefix, gauge->body);
  else if (gauge->type == HC_GAUGE_MOORING && gauge->mooring >= body->mooring_count)
    hc_complaints_add(complaints, hc_given_place_of(given, "mooring"),
                      "%smooring must be below the number of moorings of '%s', %d, not %d", given->prefix,
                      gauge->body, body->mooring_count, gauge->mooring);
}

static void check_absorption(const hc_scene *scene, const hc_scene_absorption *absorption,
                             const hc_given *given, hc_complaints *complaints) {
  const double *const g = scene->gravity;
  if (g[0] == 0.0 && g[1] == 0.0 && g[2] == 0.0 && !hc_given_is_bad(given, "ocean_height"))
    hc_complaints_add(complaints, hc_given_place_of(given, "ocean_height"),
                      "%socean_height must not be given without gravity, which says where up is",
                      given->prefix);
  if (hc_given_is_bad(given, "wall") || !hc_given_has(given, "wall")) return;
  const int number = hc_scene_surface_named(scene, absorption->wall);
  if (number < 0 || hc_scene_is_body(scene, number))
    hc_complaints_add(complaints, hc_given_place_of(given, "wall"),
                      "%swall must be the name of a wall of the scene, not '%s'", given->prefix,
                      absorption->wall);
  else if (!hc_scene_stands(scene, number))
    hc_complaints_add(complaints, hc_given_place_of(given, "wall"),
                      "%swall must be one that stands still, not '%s', which has a motion", given->prefix,
                      absorption->wall);
}

static bool falls_along_an_axis(const hc_scene *scene) {
  const double *const g = scene->gravity;
  return (g[0] != 0.0) + (g[1] != 0.0) + (g[2] != 0.0) == 1;
}

static void check_window(const hc_scene *scene, const hc_given *given, hc_complaints *complaints) {
  const hc_scene_window *const window = &scene->window;
  const hc_place place = hc_given_place_of(given, "window.follow");
  if (hc_given_is_bad(given, "window.follow") || !hc_scene_has_window(scene)) {
    if (hc_given_has(given, "window.wall") && !hc_given_is_bad(given, "window.follow"))
      require(given, "window.follow", "with window.wall", complaints);
    return;
  }
  if (!body_named(scene, window->follow) && !hc_given_value_of(given, "bodies")->bad)
    hc_complaints_add(complaints, place, "window.follow must be the name of a body of the scene, not '%s'",
                      window->follow);
  if (!falls_along_an_axis(scene) && !hc_given_is_bad(given, "gravity"))
    hc_complaints_add(complaints, place,
                      "window.follow must not be given unless gravity acts along one axis: across it the "
                      "window goes along");
  require(given, "window.wall", "with window.follow", complaints);
  if (!hc_given_has(given, "window.wall") || hc_given_value_of(given, "boundary.walls")->bad) return;
  const hc_wall *const wall = &scene->boundary.walls[0];
  if (scene->boundary.wall_count != 1 || strcmp(wall->name, window->wall) != 0)
    hc_complaints_add(complaints, hc_given_place_of(given, "window.wall"),
                      "window.wall must be the name of the scene's only wall, not '%s' of %d walls",
                      window->wall, scene->boundary.wall_count);
  else if (wall->form == HC_FORM_PLANE || wall->inside != HC_INSIDE_FLUID ||
           wall->motion.type != HC_WALL_STANDS || (wall->form == HC_FORM_MESH && !wall->mesh.closed) ||
           (wall->form == HC_FORM_REVOLUTION && !wall->revolution.closed))
    hc_complaints_add(complaints, hc_given_place_of(given, "window.wall"),
                      "window.wall must be a container (inside: fluid, no plane, no sheet) without a motion, "
                      "which '%s' is not",
                      window->wall);
  for (int k = 0; k < scene->fluid.block_count; k++)
    if (!scene->fluid.blocks[k].rest_state[0] || scene->fluid.blocks[k].start > 0.0)
      hc_complaints_add(complaints, place,
                        "window.follow must not be given unless a rest_state fills every block at the start, "
                        "not so fluid.blocks[%d]: the window is filled anew from it",
                        k);
}

static void check_gauge(hc_scene *scene, int index, const hc_given *given, hc_complaints *complaints) {
  hc_scene_gauge *gauge = &scene->output.gauges[index];
  if (!hc_given_is_bad(given, "at")) complete_point(scene, gauge, given, complaints);
  check_radius(scene, gauge, given, complaints);
  for (int k = 0; k < 3 && !hc_given_is_bad(given, "box.min") && !hc_given_is_bad(given, "box.max"); k++)
    if (gauge->box.min[k] > gauge->box.max[k])
      hc_complaints_add(complaints, hc_given_place_of(given, "box.max"),
                        "%sbox.max must be >= box.min along %c", given->prefix, axes[k]);
  if (gauge->type == HC_GAUGE_FLOW && !hc_given_is_bad(given, "axis") && !hc_given_is_bad(given, "box.min") &&
      !hc_given_is_bad(given, "box.max"))
    check_rectangle(gauge, given, complaints);
  if (hc_given_has(given, "wall") && !hc_given_is_bad(given, "wall")) {
    if (hc_scene_surface_named(scene, gauge->wall) < 0)
      hc_complaints_add(complaints, hc_given_place_of(given, "wall"),
                        "%swall must be the name of a wall or body of the scene, not '%s'", given->prefix,
                        gauge->wall);
  }
  if (hc_given_has(given, "body") && !hc_given_is_bad(given, "body"))
    check_gauged_body(scene, gauge, given, complaints);
  if ((gauge->type == HC_GAUGE_FRONT || gauge->type == HC_GAUGE_FLOW) && gauge->axis == 0 &&
      !hc_given_is_bad(given, "axis"))
    hc_complaints_add(complaints, hc_given_place_of(given, "axis"), "%saxis must be a direction, not none",
                      given->prefix);
  if (hc_given_is_bad(given, "name")) return;
  if (strpbrk(gauge->name, ",\""))
    hc_complaints_add(complaints, hc_given_place_of(given, "name"),
                      "%sname must do without commas and quotes, not %s", given->prefix, gauge->name);
  if (strcmp(gauge->name, "time") == 0)
    hc_complaints_add(complaints, hc_given_place_of(given, "name"),
                      "%sname must not be time, the first column", given->prefix);
  for (int k = 0; k < index; k++) {
    const hc_scene_gauge *earlier = &scene->output.gauges[k];
    if (strcmp(earlier->name, gauge->name) == 0 || makes_column(earlier, gauge->name) ||
        makes_column(gauge, earlier->name))
      hc_complaints_add(complaints, hc_given_place_of(given, "name"),
                        "%sname must give columns of its own, '%s' has one in common with gauge %d, '%s'",
                        given->prefix, gauge->name, k, earlier->name);
  }
}

static void check_rest(const hc_scene *scene, const hc_given *given, hc_complaints *complaints) {
  static const char key[] = "fluid.rest.damping_end";
  const hc_scene_rest *const rest = &scene->fluid.rest;
  if (hc_given_is_bad(given, key) || hc_given_is_bad(given, "fluid.rest.damping_start") ||
      (rest->damping_end > 0.0 && rest->damping_end <= rest->damping_start))
    return;
  char end[HC_PARAM_NUMBER_TEXT], start[HC_PARAM_NUMBER_TEXT];
  hc_params_number_text(rest->damping_end, end);
  hc_params_number_text(rest->damping_start, start);
  hc_complaints_add(complaints, hc_given_place_of(given, key),
                    "%s must be > 0 and <= fluid.rest.damping_start (%s), not %s", key, start, end);
}

void hc_rules_apply(hc_scene *scene, const hc_given *given, const char *file_name,
                    hc_complaints *complaints) {
  if (!hc_given_has(given, "name")) name_scene(scene, file_name);
  check_name(scene, given, complaints);
  check_support(scene, given, complaints);
  check_domain(scene, given, complaints);
  check_limits(scene, given, complaints);
  check_iterations(given, "solver.density_iterations.min", "solver.density_iterations.max",
                   scene->solver.density_iterations, complaints);
  check_iterations(given, "solver.divergence_iterations.min", "solver.divergence_iterations.max",
                   scene->solver.divergence_iterations, complaints);
  check_rest(scene, given, complaints);
  const hc_given_value *blocks = hc_given_value_of(given, "fluid.blocks");
  for (int k = 0; k < blocks->item_count; k++)
    if (!blocks->items[k].bad) check_block(&scene->fluid.blocks[k], &blocks->items[k], complaints);
  const hc_given_value *emitters = hc_given_value_of(given, "fluid.emitters");
  for (int k = 0; k < emitters->item_count; k++)
    if (!emitters->items[k].bad)
      hc_source_rules_emitter(&scene->fluid.emitters[k], &emitters->items[k], complaints);
  const hc_given_value *walls = hc_given_value_of(given, "boundary.walls");
  for (int k = 0; k < walls->item_count; k++)
    if (!walls->items[k].bad) check_wall(scene, k, &walls->items[k], complaints);
  const hc_given_value *bodies = hc_given_value_of(given, "bodies");
  for (int k = 0; k < bodies->item_count; k++)
    if (!bodies->items[k].bad) check_body(scene, k, &bodies->items[k], complaints);
  check_surface_names(scene, given, complaints);
  complete_viscosity(scene, given, complaints);
  complete_friction(scene, given, complaints);
  check_window(scene, given, complaints);
  const hc_given_value *absorptions = hc_given_value_of(given, "absorption");
  for (int k = 0; k < absorptions->item_count; k++)
    if (!absorptions->items[k].bad)
      check_absorption(scene, &scene->absorptions[k], &absorptions->items[k], complaints);
  const hc_given_value *gauges = hc_given_value_of(given, "output.gauges");
  for (int k = 0; k < gauges->item_count; k++)
    if (!gauges->items[k].bad) check_gauge(scene, k, &gauges->items[k], complaints);
}

static void drop_unused(const hc_given *given, void *owner, hc_complaints *warnings) {
  for (int k = 0; k < given->table->count; k++) {
    const hc_param *param = &given->table->params[k];
    const hc_given_value *value = &given->values[k];
    if (param->kind == HC_PARAM_LIST) {
      char *items = *(char **)((char *)owner + param->offset);
      for (int item = 0; item < value->item_count; item++)
        drop_unused(&value->items[item], items + (size_t)item * param->items->size, warnings);
    } else if (value->node && !hc_params_used(given->table, param, owner)) {
      char reason[2 * HC_PARAM_PATH];
      hc_params_chooser_text(given->table, param, owner, reason, sizeof reason);
      hc_complaints_add(warnings, value->place, "%s%s is not used: %s%s", given->prefix, param->path,
                        given->prefix, reason);
      hc_fill_default(param, owner);
    }
  }
}

void hc_rules_drop_unused(hc_scene *scene, const hc_given *given, hc_complaints *warnings) {
  drop_unused(given, scene, warnings);
}
