#include "footprint.h"

#include "setup/controls.h"
#include "setup/settings.h"
#include "state/copy.h"

#include <math.h>

enum {
  SORT = 12,   /* the sort's work space, which forces use too */
  CHOSEN = 28, /* who is active, what is asked of each, where all were, and rows of lists of some */
  ROW = 4,     /* where a list's row begins */
  ENTRIES =
      17,    /* bytes of a row's entries, times the cube of the support radius in spacings: fluid at rest */
  CELLS = 4, /* bytes of a brick's tables for a particle of fluid, where eight fill a cell, */
  WALL_CELLS = 30, /* and of a wall, which fills few cells of a brick */
  EXCHANGE = 48    /* a ghost's share of cells and messages, its owner's included */
};

/* Arrays grow by a sixteenth beyond what is asked; half of that is touched. */
static const double SLACK = 1.03;

static bool any_moves(const hc_scene *scene) {
  return hc_settings_features(scene) & HC_FOR_MOVERS;
}

static bool has_own_steps(const hc_scene *scene) {
  return hc_settings_features(scene) & HC_FOR_INDIVIDUAL;
}

static double entries(const hc_scene *scene) {
  const double reach = has_own_steps(scene) ? 1.0 + scene->time_step.margin : 1.0;
  return ENTRIES * pow(reach * scene->support_radius / scene->particle_spacing, 3);
}

/* Boundary particles of scenes where some walls move are taken for moving ones. */
static unsigned wall_kind(const hc_scene *scene) {
  return any_moves(scene) ? HC_BOUNDARY | HC_MOVED : HC_BOUNDARY;
}

double hc_footprint_places(const hc_scene *scene) {
  static const double WITH_AIR = 1.2;
  return hc_scene_has_window(scene) ? WITH_AIR * (double)hc_particles_state_bytes(HC_WINDOW, 0) : 0.0;
}

double hc_footprint_fluid(const hc_scene *scene) {
  /* to go back to, and one more while a checkpoint is written */
  const int back = hc_setup_goes_back(scene), copies = back + (back > 1); /* and the state of now */
  const bool rigid = hc_settings_boundary(scene)->collide != NULL;
  return SLACK *
             ((double)hc_particles_bytes(HC_FLUID, hc_settings_features(scene)) + SORT + CELLS + 2 * ROW +
              entries(scene) + (rigid ? 2 * sizeof(hc_record) : 0) + (has_own_steps(scene) ? CHOSEN : 0)) +
         copies * hc_footprint_fluid_state(scene) + SLACK * hc_footprint_places(scene);
}

double hc_footprint_wall(const hc_scene *scene) {
  const bool wetted = hc_settings_boundary(scene)->walls == HC_WALLS_PRESSURE;
  return SLACK * ((double)hc_particles_bytes(wall_kind(scene), hc_settings_features(scene)) + WALL_CELLS +
                  (any_moves(scene) ? SORT : 0) + (wetted ? ROW + 0.5 * entries(scene) : 0.0));
}

double hc_footprint_ghost(const hc_scene *scene) {
  double records = 0.0;
  for (int field = 0; field < HC_FIELD_COUNT; field++)
    if (hc_field_is_there(&hc_fields[field], HC_FLUID, hc_settings_features(scene)) &&
        hc_field_has_ghosts(&hc_fields[field], hc_settings_features(scene)))
      records += (double)hc_fields[field].bytes;
  return records + EXCHANGE;
}

double hc_footprint_fluid_state(const hc_scene *scene) {
  return (double)hc_particles_state_bytes(HC_FLUID, hc_settings_features(scene));
}

double hc_footprint_wall_state(const hc_scene *scene) {
  return (double)hc_particles_state_bytes(wall_kind(scene), hc_settings_features(scene));
}

double hc_footprint_least(const hc_scene *scene, const hc_setup_plan *plan, int64_t ranks) {
  return HC_FOOTPRINT_PROGRAM + (hc_footprint_fluid(scene) * (double)plan->fluid_count +
                                 hc_footprint_wall(scene) * (double)plan->boundary_count) /
                                    (double)ranks;
}
