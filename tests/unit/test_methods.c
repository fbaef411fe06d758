/* The tables of solvers and step controls: their names are the scene's, and they say what goes together. */
#include "base/memory.h"
#include "scene/params.h"
#include "scene/reader.h"
#include "setup/controls.h"
#include "setup/methods.h"
#include "setup/solvers.h"
#include "solver/pcisph.h"
#include "stepping/adaptive.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

START_TEST(rows_are_called_as_in_scenes) {
  hc_scene scene = {0};
  for (const hc_choice *c = hc_params_find(&hc_params_scene, "solver.method")->choices; c->name; c++) {
    scene.solver.method = (hc_solver_method)c->value;
    const hc_solver_ops *solver = hc_setup_solver_ops(&scene);
    ck_assert_str_eq(solver->name, c->name);
    ck_assert(solver->step && solver->densities && solver->walls);
    hc_time_control known;
    ck_assert(!solver->steadier || hc_setup_control_named(solver->steadier, &known));
  }
  for (const hc_choice *c = hc_params_find(&hc_params_scene, "time_step.control")->choices; c->name; c++) {
    scene.time_step.control = (hc_time_control)c->value;
    const hc_control_ops *control = hc_setup_control_ops(&scene);
    hc_time_control named;
    ck_assert_str_eq(control->name, c->name);
    ck_assert(hc_setup_control_named(c->name, &named) && (int)named == c->value);
    char key[HC_PARAM_PATH];
    snprintf(key, sizeof key, "time_step.%s", control->speed_key);
    ck_assert_ptr_nonnull(hc_params_find(&hc_params_scene, key));
    snprintf(key, sizeof key, "time_step.%s", control->longest_key);
    ck_assert_ptr_nonnull(hc_params_find(&hc_params_scene, key));
  }
}
END_TEST

START_TEST(a_solver_says_which_controls_it_works_with) {
  static const char *const two[] = {"constant", "cfl", NULL};
  const hc_solver_ops any = {.name = "any"}, some = {.name = "some", .controls = two};
  ck_assert(hc_solver_works_with(&any, "adaptive"));
  ck_assert(hc_solver_works_with(&some, "cfl") && !hc_solver_works_with(&some, "adaptive"));
}
END_TEST

static hc_scene read_scene(const char *more) {
  static const hc_scene_limits limits = {.complete = hc_setup_complete};
  hc_scene scene;
  hc_error error = {.text = ""};
  char text[512];
  snprintf(text, sizeof text, "particle_spacing: 0.02\nend_time: 1\n%s", more);
  if (hc_scene_read_text(&scene, "t.yaml", text, strlen(text), NULL, 0, &limits, NULL, &error) != HC_OK)
    ck_abort_msg("%s", error.text);
  return scene;
}

START_TEST(defaults_hang_on_the_methods) {
  hc_scene plain = read_scene(""), own = read_scene("solver: {method: pcisph}\ntime_step: {control: cfl}\n"),
           adaptive = read_scene("solver: {method: pcisph}\n");
  ck_assert(plain.solver.density_error_avg == 1e-4 && plain.solver.density_iterations.min == 2);
  ck_assert(own.solver.density_error_avg == 0.01 && own.solver.density_iterations.min == 3 &&
            own.solver.density_iterations.max == 100);
  ck_assert(adaptive.solver.density_iterations.max == 3);
  hc_pcisph_settings *settings = (hc_pcisph_settings *)hc_setup_solver_settings(&own);
  ck_assert(settings->common.rest_density == own.fluid.rest_density && settings->density_error_max == 0.1 &&
            settings->density_max == 100 && settings->gradient_square > 0.0);
  hc_free(settings);
  hc_control control = hc_setup_control(&adaptive);
  const hc_adaptive_settings *steps = (const hc_adaptive_settings *)control.settings;
  ck_assert(control.ops == &hc_control_adaptive && steps->common.longest == 0.2 * sqrt(0.04 / 9.81) &&
            steps->error_max == 0.1);
  hc_control_free(&control);
  hc_scene_free(&plain);
  hc_scene_free(&own);
  hc_scene_free(&adaptive);
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("methods");
  TCase *const cases = tcase_create("tables");
  tcase_add_test(cases, rows_are_called_as_in_scenes);
  tcase_add_test(cases, a_solver_says_which_controls_it_works_with);
  tcase_add_test(cases, defaults_hang_on_the_methods);
  suite_add_tcase(suite, cases);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
