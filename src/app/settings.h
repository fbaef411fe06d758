/* From a scene's keys to what solver, time step and walls are told. All local. */
#ifndef HC_SETTINGS_H
#define HC_SETTINGS_H

#include "scene/scene.h"
#include "solver/solver.h"
#include "stepping/time_step.h"

const hc_solver_ops *hc_settings_solver_ops(const hc_scene *scene);
hc_solver_settings hc_settings_solver(const hc_scene *scene);

/* What bounds the steps of a scene. */
hc_step_settings hc_settings_step(const hc_scene *scene);

/* The boundary method, and the factor that its `prepare` takes. */
const hc_boundary_ops *hc_settings_boundary(const hc_scene *scene);
double hc_settings_wall_factor(const hc_scene *scene);

#endif
