/* The commands that run nothing: check, info, diff, keys. */
#include "commands.h"
#include "io/diff.h"
#include "io/info.h"
#include "particles/particles.h"
#include "scene/params.h"
#include "scene_input.h"
#include "setup/populate.h"
#include "setup/world_frame.h"
#include "simulation.h"

#include <math.h>
#include <stdio.h>

int hc_command_fail(const hc_error *error) {
  fflush(stdout);
  fprintf(stderr, "halocline: error: %s\n", error->text);
  return error->status;
}

void hc_command_warn(const hc_warnings *warnings) {
  for (int k = 0; k < warnings->count; k++) fprintf(stderr, "halocline: warning: %s\n", warnings->text[k]);
}

/* Standard output, written out: a full disk must not look like success. */
static int finish_output(void) {
  if (fflush(stdout) == 0 && !ferror(stdout)) return HC_OK;
  fprintf(stderr, "halocline: error: standard output could not be written\n");
  return HC_IO_FAILED;
}

static void report_check(const hc_scene *scene, const hc_setup_plan *plan, int64_t ranks) {
  const double bytes = hc_simulation_memory(plan, ranks);
  double v_max = 0.0, gravity = 0.0;
  for (int block = 0; block < scene->fluid.block_count; block++) {
    const hc_block *b = &scene->fluid.blocks[block];
    double v2 = 0.0;
    for (int axis = 0; axis < 3; axis++) v2 += b->velocity[axis] * b->velocity[axis];
    v_max = fmax(v_max, sqrt(v2) + (b->flow.type == HC_FLOW_NONE ? 0.0 : b->flow.speed));
  }
  for (int axis = 0; axis < 3; axis++) gravity += scene->gravity[axis] * scene->gravity[axis];
  const hc_step_report start = {.v_max = v_max, .force_max = sqrt(gravity)};
  const hc_step_settings step = hc_step_settings_of(scene);
  hc_step_bound bound;
  const double dt = hc_time_step_next(&step, 0.0, 0.0, &start, &bound);
  printf("scene               %s\n", scene->name);
  printf("particle spacing    %g m, support radius %g m\n", scene->particle_spacing, scene->support_radius);
  printf("fluid particles     %lld\n", (long long)plan->fluid_count);
  printf("boundary particles  %lld\n", (long long)plan->boundary_count);
  printf("first time step     at most %g s, bounded by: %s\n", dt, hc_step_bound_name(bound));
  printf("end time            %g s, at least %.0f steps\n", scene->end_time,
         ceil(scene->end_time / (step.control == HC_STEP_CONSTANT ? step.size : step.max)));
  printf("memory per rank     about %.0f MiB on %lld rank%s\n", bytes / 1048576.0, (long long)ranks,
         ranks == 1 ? "" : "s");
}

int hc_command_check(const hc_options *options) {
  hc_error error = {.status = HC_OK};
  hc_scene scene;
  const char *names[HC_FIELD_COUNT];
  const hc_scene_limits limits = hc_scene_input_limits(names);
  hc_warnings warnings = {0};
  if (hc_scene_read(&scene, options->files[0], options->overrides, options->override_count, &limits,
                    &warnings, &error) != HC_OK)
    return hc_command_fail(&error);
  hc_command_warn(&warnings);
  hc_warnings_free(&warnings);
  hc_frame frame;
  hc_setup_plan plan;
  if (hc_setup_frame(&scene, &frame, &error) == HC_OK &&
      hc_setup_plan_make(&scene, &frame, &plan, &error) == HC_OK) {
    report_check(&scene, &plan, options->ranks);
    hc_setup_plan_free(&plan);
  }
  hc_scene_free(&scene);
  return error.status == HC_OK ? finish_output() : hc_command_fail(&error);
}

int hc_command_info(const hc_options *options) {
  hc_error error = {.status = HC_OK};
  if (hc_info_print(options->files[0], options->json, stdout, &error) != HC_OK)
    return hc_command_fail(&error);
  return finish_output();
}

int hc_command_diff(const hc_options *options) {
  hc_error error = {.status = HC_OK};
  const hc_diff_options how = {options->tolerance, options->json};
  const int code = hc_diff_run(options->files[0], options->files[1], &how, stdout, &error);
  if (code == 2) hc_command_fail(&error);
  const int written = finish_output();
  return code < 2 && written != HC_OK ? 2 : code;
}

int hc_command_keys(const hc_options *options) {
  hc_error error = {.status = HC_OK};
  if (hc_params_print(stdout, options->solver, &error) != HC_OK) return hc_command_fail(&error);
  return finish_output();
}
