/* The solvers as scenes choose them: one row of a table each. All local. */
#ifndef HC_SETUP_SOLVERS_H
#define HC_SETUP_SOLVERS_H

#include "scene/findings.h"
#include "scene/scene.h"
#include "solver/solver.h"

const hc_solver_ops *hc_setup_solver_ops(const hc_scene *scene);

/* The solver's own settings, the common ones first; freed with hc_free. */
hc_solver_settings *hc_setup_solver_settings(const hc_scene *scene);

/* Defaults that hang on the solver, and what of its keys contradicts itself. `by_errors`: the step control
 * follows the density errors. */
void hc_setup_solver_complete(hc_scene *scene, bool by_errors, hc_findings *findings);

/* The longest time step with which the solver is stable, s; INFINITY where steps are bounded by other things.
 */
double hc_setup_solver_longest(const hc_scene *scene);

#endif
