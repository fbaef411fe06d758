/* A large surface sampled by all ranks: seconds and memory of each.
 *
 * An undulating ring of triangles about a spacing long. Usage: [mpirun -n N] bench_sampling [SAMPLES
 * [LAYERS]]; default: 100,000 samples of a layer, about, 1 layer. The digest of the samples is the same on
 * any number of ranks. */
#include "base/check.h"
#include "base/memory.h"
#include "base/timer.h"
#include "geometry/surface_samples.h"
#include "setup/meshes.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const double turn = 2 * 3.14159265358979323846;

static hc_mesh ring(int around, int across) {
  hc_mesh mesh = hc_mesh_make(around * across, 2 * around * across);
  int32_t t = 0;
  for (int i = 0; i < around; i++)
    for (int j = 0; j < across; j++) {
      const double u = turn * i / around, v = turn * j / across;
      const double radius = 0.4 * (1 + 0.08 * sin(9 * u) * cos(5 * v)), reach = 1 + radius * cos(v);
      const int32_t next = (i + 1) % around, right = (j + 1) % across;
      const int32_t corner[4] = {i * across + j, next * across + j, next * across + right,
                                 i * across + right};
      double *const x = mesh.vertex[corner[0]];
      x[0] = reach * cos(u);
      x[1] = reach * sin(u);
      x[2] = radius * sin(v);
      for (int half = 0; half < 2; half++, t++) {
        mesh.triangle[t][0] = corner[0];
        mesh.triangle[t][1] = corner[half + 1];
        mesh.triangle[t][2] = corner[half + 2];
      }
    }
  return mesh;
}

/* Of the samples of all ranks in their order (FNV-1a). */
static uint64_t digest(hc_comm *comm, const hc_surface *surface) {
  void *all;
  size_t bytes;
  hc_comm_gather(comm, surface->samples, (size_t)surface->samples_held * sizeof *surface->samples, 0, &all,
                 &bytes);
  uint64_t value = 14695981039346656037u;
  for (size_t k = 0; k < bytes; k++) value = (value ^ ((const unsigned char *)all)[k]) * 1099511628211u;
  hc_free(all);
  return value;
}

int main(int argc, char **argv) {
  hc_comm comm;
  hc_comm_start(&comm, &argc, &argv);
  const double wanted = argc > 1 ? atof(argv[1]) : 1e5;
  const int layers = argc > 2 ? atoi(argv[2]) : 1;
  HC_CHECK(wanted >= 100 && layers > 0, "bench_sampling [SAMPLES [LAYERS]], got %g and %d", wanted, layers);
  const double spacing = sqrt(17.5 / wanted); /* m, of the ring's 16 m2 and their curvature */
  const double before = hc_seconds();
  hc_error error;
  bool turned;
  hc_mesh mesh = ring((int)(6 / spacing / 1.5), (int)(2.5 / spacing / 1.5));
  HC_CHECK(hc_mesh_check(&mesh, false, &turned, &error) == HC_OK, "%s", error.text);
  const int32_t triangles = mesh.triangle_count;
  hc_surface *const surface = hc_surface_make(&mesh, true);
  const hc_parts parts = hc_setup_parts(&comm);
  const size_t base = hc_memory_now();
  double begin = hc_seconds(), busy = -hc_comm_busy_seconds(&comm);
  HC_CHECK(hc_surface_samples_make(surface, spacing, layers, false, &parts, &error) == HC_OK, "%s",
           error.text);
  busy += hc_comm_busy_seconds(&comm);
  double of[] = {hc_seconds() - begin, begin - before,          busy,
                 (double)base,         (double)hc_memory_now(), (double)hc_memory_peak()};
  hc_comm_max_f64(&comm, of, sizeof of / sizeof *of);
  const uint64_t value = digest(&comm, surface);
  if (comm.rank == 0)
    printf(
        "%lld samples of %d triangles on %d ranks, digest %016llx: tree %.2f s, samples %.2f s, the busiest "
        "rank %.2f s of its processor; MiB of the largest rank: %.1f before, %.1f at its highest, %.1f "
        "after\n",
        (long long)surface->sample_count, triangles, comm.size, (unsigned long long)value, of[1], of[0],
        of[2], of[3] / 1048576, of[5] / 1048576, of[4] / 1048576);
  hc_surface_free(surface);
  hc_comm_finish(&comm);
  return 0;
}
