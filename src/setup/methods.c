#include "methods.h"

#include "setup/controls.h"
#include "setup/rest_states.h"
#include "setup/settings.h"
#include "setup/solvers.h"

#include <stdio.h>
#include <string.h>

static bool is_good(const hc_findings *findings, const char *path) {
  return !hc_given_is_bad(findings->given, path);
}

/* The names of the boundary methods that a solver works with: "a, b". */
static void name_walls(const hc_solver_ops *solver, char *text, size_t size) {
  size_t used = 0;
  hc_scene scene = {0};
  text[0] = '\0';
  for (int k = HC_BOUNDARY_AKINCI2012; k <= HC_BOUNDARY_HARADA2007 && used < size; k++) {
    scene.boundary.method = (hc_boundary_method)k;
    const hc_boundary_ops *walls = hc_settings_boundary(&scene);
    if (solver->walls >> walls->walls & 1)
      used += (size_t)snprintf(text + used, size - used, "%s%s", used ? ", " : "", walls->name);
  }
}

static void check_walls(const hc_scene *scene, hc_findings *findings) {
  const hc_boundary_ops *walls = hc_settings_boundary(scene);
  if (walls->walls != HC_WALLS_MIRRORED && walls->walls != HC_WALLS_PRESSURE &&
      is_good(findings, "fluid.viscosity.model") && scene->fluid.viscosity.model == HC_VISCOSITY_LAMINAR)
    hc_findings_error(findings, "fluid.viscosity.model",
                      "fluid.viscosity.model must not be laminar unless boundary.method is akinci2012 or "
                      "ihmsen2010: walls of the others do not hold the fluid");
  const hc_solver_ops *solver = hc_setup_solver_ops(scene);
  if (solver->walls >> walls->walls & 1) return;
  char names[128];
  name_walls(solver, names, sizeof names);
  hc_findings_error(findings, "boundary.method", "boundary.method must be %s with solver.method %s: %s",
                    names, solver->name, solver->walls_why);
}

/* Positions that are predicted again and again go by the walls' gradient at the step's beginning, which is
 * too far from that of a squared density. */
static void check_wall_density(hc_scene *scene, hc_findings *findings) {
  if (hc_setup_solver_ops(scene)->squared_walls) return;
  if (!hc_given_has(findings->given, "boundary.wall_density"))
    scene->boundary.wall_density = HC_WALL_DENSITY_SUM;
  else if (scene->boundary.wall_density != HC_WALL_DENSITY_SUM)
    hc_findings_error(findings, "boundary.wall_density",
                      "boundary.wall_density must be sum with solver.method %s: squared needs dfsph or wcsph",
                      hc_setup_solver_ops(scene)->name);
}

/* What happens once in a step of the run, which must be no block of many; null: nothing. */
static const char *once_a_step(const hc_scene *scene) {
  if (scene->body_count > 0) return "bodies: they move";
  if (hc_setup_has_rest_states(scene) || hc_setup_has_refills(scene)) return "rest states: they are damped";
  return NULL;
}

/* The solver's control that a scene has by default. */
static const char *default_control(const hc_scene *scene, const hc_solver_ops *solver) {
  int k = 0;
  hc_scene chosen = {.body_count = 0};
  for (; solver->controls[k + 1] && once_a_step(scene); k++)
    if (hc_setup_control_named(solver->controls[k], &chosen.time_step.control) &&
        !hc_setup_control_ops(&chosen)->in_blocks)
      break;
  return solver->controls[k];
}

static void check_whole_steps(const hc_scene *scene, hc_findings *findings) {
  const char *const what = once_a_step(scene);
  if (what && is_good(findings, "time_step.control") && hc_setup_control_ops(scene)->in_blocks)
    hc_findings_error(
        findings, "time_step.control",
        "time_step.control must not be %s with %s once in a step of the run, which is a block of many",
        hc_setup_control_ops(scene)->name, what);
}

static void check_bodies(const hc_scene *scene, hc_findings *findings) {
  if (scene->body_count == 0) return;
  if (is_good(findings, "boundary.method") && hc_settings_boundary(scene)->walls != HC_WALLS_MIRRORED)
    hc_findings_error(findings, "boundary.method",
                      "boundary.method must be akinci2012 with bodies: the others push them with no force "
                      "that is known");
}

static void check_control(hc_scene *scene, hc_findings *findings) {
  const hc_solver_ops *solver = hc_setup_solver_ops(scene);
  if (!solver->controls) return;
  if (!hc_given_has(findings->given, "time_step.control"))
    hc_setup_control_named(default_control(scene, solver), &scene->time_step.control);
  else if (!hc_solver_works_with(solver, hc_setup_control_ops(scene)->name))
    hc_findings_error(findings, "time_step.control", "time_step.control must not be %s with solver.method %s",
                      hc_setup_control_ops(scene)->name, solver->name);
}

void hc_setup_complete(hc_scene *scene, hc_findings *findings) {
  const bool solver = is_good(findings, "solver.method"), control = is_good(findings, "time_step.control");
  if (solver && is_good(findings, "boundary.method")) check_walls(scene, findings);
  if (solver && is_good(findings, "boundary.wall_density")) check_wall_density(scene, findings);
  if (solver && control) check_control(scene, findings);
  if (control) check_bodies(scene, findings);
  if (control) check_whole_steps(scene, findings);
  if (solver) hc_setup_solver_complete(scene, control && hc_setup_control_ops(scene)->by_errors, findings);
  if (control) hc_setup_control_complete(scene, findings);
}
