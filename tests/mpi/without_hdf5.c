/* A program of the rooms that simulate, linked without HDF5: some steps of a column of water, in memory. */
#include "base/check.h"
#include "scene/reader.h"
#include "simulation/step.h"

#include <dlfcn.h>
#include <stdio.h>
#include <string.h>

int main(int argc, char **argv) {
  hc_comm comm;
  hc_comm_start(&comm, &argc, &argv);
  hc_error error = {.status = HC_OK};
  hc_scene scene;
  static const char text[] =
      "particle_spacing: 0.05\nend_time: 1\nfluid:\n  blocks: [{box: {min: [0, 0, 0], max: "
      "[0.4, 0.4, 0.4]}}]\nboundary:\n  walls: [{box: {min: [0, 0, 0], max: [0.8, 0.4, "
      "0.8]}}]\n";
  HC_CHECK(hc_scene_read_text(&scene, "text", text, strlen(text), NULL, 0, NULL, NULL, &error) == HC_OK, "%s",
           error.text);
  hc_simulation simulation;
  HC_CHECK(hc_simulation_init(&simulation, &comm, &scene, &error) == HC_OK, "%s", error.text);
  for (int step = 0; step < 5; step++)
    HC_CHECK(hc_simulation_step(&simulation, &error) == HC_OK, "%s", error.text);
  HC_CHECK(!dlsym(RTLD_DEFAULT, "H5open"), "HDF5 is there all the same");
  const long long particles = (long long)simulation.world.fluid_total;
  hc_simulation_free(&simulation);
  hc_scene_free(&scene);
  if (comm.rank == 0) printf("5 steps of %lld particles without HDF5\n", particles);
  hc_comm_finish(&comm);
  return 0;
}
