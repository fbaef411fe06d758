/* The public interface: a thin skin over the simulation, see include/halocline/halocline.h. */
#include "halocline/halocline.h"

#include "base/memory.h"
#include "io/rest_file.h"
#include "io/run_dir.h"
#include "io/snapshot.h"
#include "io/text.h"
#include "setup/scene_input.h"
#include "simulation/step.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

struct hc_session {
  hc_comm comm;
};

struct hc_run {
  hc_comm *comm;
  hc_scene scene;
  hc_simulation simulation;
  int snapshots; /* written so far */
};

/* Callers may leave the error out, the inside always has one to agree on. */
static hc_status hand_over(const hc_error *problem, hc_error *error) {
  if (error && problem->status != HC_OK) *error = *problem;
  return problem->status;
}

/* ---- the session ---- */

hc_status hc_session_start(const int *communicator, hc_session **session, hc_error *error) {
  *session = hc_alloc_zero(1, sizeof **session);
  const hc_status status = hc_comm_start_on(&(*session)->comm, communicator, error);
  if (status == HC_OK) return HC_OK;
  hc_free(*session);
  *session = NULL;
  return status;
}

void hc_session_end(hc_session *session) {
  if (!session) return;
  hc_comm_finish(&session->comm);
  hc_free(session);
}

int hc_session_rank(const hc_session *session) {
  return session->comm.rank;
}

int hc_session_size(const hc_session *session) {
  return session->comm.size;
}

/* ---- the run ---- */

static hc_status make_run(hc_session *session, const hc_scene_input *input, hc_run **run, hc_error *error) {
  hc_error problem = {.status = HC_OK};
  hc_run *made = hc_alloc_zero(1, sizeof *made);
  made->comm = &session->comm;
  *run = NULL;
  if (hc_scene_input_read(made->comm, input, &made->scene, NULL, &problem) == HC_OK) {
    if (hc_simulation_init(&made->simulation, made->comm, &made->scene, &problem) == HC_OK) {
      hc_setup_free_start(&made->scene);
      *run = made;
    } else {
      hc_scene_free(&made->scene);
    }
  }
  if (!*run) hc_free(made);
  return hand_over(&problem, error);
}

hc_status hc_run_from_file(hc_session *session, const char *path, const char *const *overrides,
                           int override_count, hc_run **run, hc_error *error) {
  const hc_scene_input input = {path, NULL, overrides, override_count, hc_rest_file_read};
  return make_run(session, &input, run, error);
}

hc_status hc_run_from_text(hc_session *session, const char *text, const char *const *overrides,
                           int override_count, hc_run **run, hc_error *error) {
  const hc_scene_input input = {"scene", text, overrides, override_count, hc_rest_file_read};
  return make_run(session, &input, run, error);
}

void hc_run_free(hc_run *run) {
  if (!run) return;
  hc_simulation_free(&run->simulation);
  hc_scene_free(&run->scene);
  hc_free(run);
}

hc_status hc_run_step(hc_run *run, hc_error *error) {
  if (hc_simulation_done(&run->simulation))
    return hc_error_set(error, HC_BAD_INPUT, "the run has reached its end time, %g s", run->scene.end_time);
  hc_error problem = {.status = HC_OK};
  do hc_simulation_step(&run->simulation, &problem);
  while (problem.status == HC_OK && run->simulation.rollback.back > 0);
  return hand_over(&problem, error);
}

/* ---- what it holds ---- */

hc_run_facts hc_run_facts_of(const hc_run *run) {
  const hc_simulation *simulation = &run->simulation;
  const hc_world *world = &simulation->world;
  const hc_step_report *report = &simulation->report;
  const bool stepped = simulation->step > 0;
  return (hc_run_facts){.step = simulation->step,
                        .time = simulation->time,
                        .dt = simulation->dt,
                        .done = hc_simulation_done(simulation),
                        .end_time = run->scene.end_time,
                        .particle_spacing = run->scene.particle_spacing,
                        .support_radius = world->frame.support_radius,
                        .rest_density = run->scene.fluid.rest_density,
                        .particle_mass = world->mass,
                        .fluid = world->fluid_total,
                        .boundary = world->boundary_total,
                        .own_fluid = world->fluid->own,
                        .own_boundary = world->boundary->own + world->moving->own,
                        .kinetic_energy = stepped ? report->kinetic_energy : NAN,
                        .potential_energy = stepped ? report->potential_energy : NAN,
                        .density_error = stepped ? report->density_error_avg : NAN,
                        .v_max = report->v_max,
                        .density_iterations = report->density_iterations,
                        .divergence_iterations = report->divergence_iterations};
}

/* Own values of a field into `to`, behind those of `skip` particles; zeros where the store lacks the field.
 */
static void copy_field(char *to, int64_t skip, const hc_particles *store, int field) {
  if (!to) return;
  const size_t bytes = hc_fields[field].bytes;
  to += (size_t)skip * bytes;
  if (store->data[field])
    memcpy(to, store->data[field], (size_t)store->own * bytes);
  else
    memset(to, 0, (size_t)store->own * bytes);
}

static void copy_store(const hc_run_particles *to, int64_t skip, const hc_frame *frame,
                       const hc_particles *store) {
  for (int64_t k = 0; to->position && k < 3 * (int64_t)store->own; k++)
    to->position[3 * skip + k] = hc_frame_to_metres(frame, (int)(k % 3), store->position[k]);
  copy_field((char *)to->velocity, skip, store, HC_FIELD_velocity);
  copy_field((char *)to->density, skip, store, HC_FIELD_density);
  copy_field((char *)to->pressure, skip, store, HC_FIELD_pressure);
  copy_field((char *)to->id, skip, store, HC_FIELD_id);
}

hc_status hc_run_get(const hc_run *run, hc_run_kind kind, const hc_run_particles *particles, int64_t room,
                     hc_error *error) {
  const hc_world *world = &run->simulation.world;
  const bool fluid = kind == HC_RUN_FLUID;
  const hc_particles *first = fluid ? world->fluid : world->boundary;
  const int64_t own = (int64_t)first->own + (fluid ? 0 : world->moving->own);
  if (room < own)
    return hc_error_set(error, HC_BAD_INPUT, "the arrays must have room for %lld particles, have %lld",
                        (long long)own, (long long)room);
  copy_store(particles, 0, &world->frame, first);
  if (!fluid) copy_store(particles, first->own, &world->frame, world->moving);
  return HC_OK;
}

hc_status hc_run_snapshot(hc_run *run, const char *directory, hc_error *error) {
  hc_error problem = {.status = HC_OK};
  char path[HC_TEXT_PATH] = "";
  if (run->comm->rank == 0) hc_text_path(path, &problem, "%s", directory);
  if (hc_comm_agree(run->comm, &problem) != HC_OK) return hand_over(&problem, error);
  hc_comm_broadcast(run->comm, path, sizeof path, 0);
  const hc_moment moment = hc_simulation_moment(&run->simulation);
  if (hc_run_dir_open(run->comm, path, HC_RUN_DIR_RESUME, &problem) == HC_OK &&
      hc_snapshot_write(run->comm, &run->scene, &moment, path, run->snapshots, &problem) == HC_OK)
    run->snapshots++;
  return hand_over(&problem, error);
}
