/* From a scene's keys to what its walls and its start are told. All local. */
#ifndef HC_SETTINGS_H
#define HC_SETTINGS_H

#include "scene/scene.h"
#include "solver/solver.h"

/* What the choice of the first step needs to know of the initial state: v_max and force_max, from the largest
 * squared speed of all fluid particles, m2/s2. */
hc_step_report hc_settings_start_report(const hc_scene *scene, double v2_max);

/* The features of a run (HC_FOR_*), by which its particles have the fields that it needs. */
unsigned hc_settings_features(const hc_scene *scene);

/* The boundary method, and the factor that its `prepare` takes. */
const hc_boundary_ops *hc_settings_boundary(const hc_scene *scene);
double hc_settings_wall_factor(const hc_scene *scene);

/* See hc_sweep.flat_wall. */
double hc_settings_flat_wall(const hc_scene *scene);

/* The friction of each wall but what laminar sweeps do, to be freed by hc_free; null: none has any. Whether
 * walls differ in it; and whether laminar sweeps do it. */
hc_wall_friction *hc_settings_friction(const hc_scene *scene);
bool hc_settings_friction_differs(const hc_scene *scene);
bool hc_settings_no_slip(const hc_scene *scene);

#endif
