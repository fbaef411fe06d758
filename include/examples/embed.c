/* A dam break inside another program: where its front is, step by step.
 *
 *   mpicc embed.c -o embed $(pkg-config --cflags --libs halocline)
 *   mpirun -n 2 ./embed SCENE.yaml STEPS [KEY=VALUE...]
 *
 * include/README.md says what to add where the library is not in the system's folders. */
#include <halocline/halocline.h>

#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>

static int fail(hc_session *session, const hc_error *error) {
  if (hc_session_rank(session) == 0) fprintf(stderr, "embed: %s\n", error->text);
  hc_session_end(session);
  MPI_Finalize();
  return error->status;
}

/* The largest x of the fluid, m. */
static double front(const hc_run *run, hc_error *error) {
  const int64_t own = hc_run_facts_of(run).own_fluid;
  double(*position)[3] = malloc((size_t)(own + 1) * sizeof *position), largest = -1e300, all;
  const hc_run_particles wanted = {.position = position[0]};
  if (hc_run_get(run, HC_RUN_FLUID, &wanted, own, error) == HC_OK)
    for (int64_t k = 0; k < own; k++)
      if (position[k][0] > largest) largest = position[k][0];
  free(position);
  MPI_Allreduce(&largest, &all, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  return all;
}

int main(int argc, char **argv) {
  MPI_Init(&argc, &argv);
  hc_session *session;
  hc_run *run;
  hc_error error = {.status = HC_OK};
  const int world = MPI_Comm_c2f(MPI_COMM_WORLD);
  if (hc_session_start(&world, &session, &error) != HC_OK) MPI_Abort(MPI_COMM_WORLD, error.status);
  const int overrides = argc > 3 ? argc - 3 : 0;
  const char *scene = argc > 1 ? argv[1] : "dam_break.yaml";
  if (hc_run_from_file(session, scene, (const char *const *)argv + 3, overrides, &run, &error) != HC_OK)
    return fail(session, &error);
  for (int step = 0; step < (argc > 2 ? atoi(argv[2]) : 100) && !hc_run_facts_of(run).done; step++) {
    if (hc_run_step(run, &error) != HC_OK) break;
    const double x = front(run, &error);
    if (hc_session_rank(session) == 0) printf("%.6f s: front at %.6f m\n", hc_run_facts_of(run).time, x);
  }
  hc_run_free(run);
  if (error.status != HC_OK) return fail(session, &error);
  hc_session_end(session);
  return MPI_Finalize();
}
