/* Surfaces sampled by all ranks together: what one process makes, shared out. */
#include "../unit/meshes.h"
#include "mpi_test.h"

#include "base/memory.h"
#include "geometry/revolution.h"
#include "geometry/surface_samples.h"
#include "setup/meshes.h"
#include "setup/populate.h"
#include "setup/world_frame.h"

#include <string.h>

static const double DX = 0.05;
static const double none[3] = {0, 0, 0}, ones[3] = {1, 1, 1}, slanted[3] = {1, -0.5, 3};

static hc_surface *surface_of(hc_mesh mesh) {
  hc_error error = {0};
  bool turned;
  hc_mesh_weld(&mesh);
  EXPECT(hc_mesh_check(&mesh, false, &turned, &error) == HC_OK);
  return hc_surface_make(&mesh, true);
}

static hc_mesh torus(void) {
  double ring[16][2];
  for (int k = 0; k < 16; k++) {
    ring[k][0] = 0.5 + 0.2 * cos(k * acos(-1.0) / 8);
    ring[k][1] = 0.2 * sin(k * acos(-1.0) / 8);
  }
  hc_mesh mesh;
  EXPECT(hc_revolution_mesh(none, slanted, (const double(*)[2])ring, 16, true, DX, &mesh, NULL) == HC_OK);
  return mesh;
}

static hc_mesh mesh_of(int which) {
  static const double thin[3] = {1, 1, 0.5 * 0.05}, tiny[3] = {0.06, 0.06, 0.06};
  return which == 0   ? torus()
         : which == 1 ? l_mesh(0.53)
         : which == 2 ? box_mesh(none, thin)
         : which == 3 ? box_mesh(none, tiny) /* with fewer samples than ranks */
                      : sphere_mesh(ones, 0.4, 3);
}

START_TEST(shares_are_the_whole) {
  for (int which = 0; which < 5; which++)
    for (int layers = 1; layers <= 2; layers++) {
      hc_surface *const shared = surface_of(mesh_of(which)), *const alone = surface_of(mesh_of(which));
      hc_error error = {0};
      const hc_parts parts = hc_setup_parts(&comm);
      EXPECT(hc_surface_samples_make(shared, DX, layers, which == 1, &parts, &error) == HC_OK);
      EXPECT(hc_surface_samples_make(alone, DX, layers, which == 1, &hc_parts_alone, &error) == HC_OK);
      int64_t first, last;
      hc_setup_share(alone->sample_count, comm.rank, comm.size, &first, &last);
      EXPECT(shared->sample_count == alone->sample_count && shared->first_sample == first &&
             shared->samples_held == last - first);
      EXPECT(memcmp(shared->samples, alone->samples + first,
                    (size_t)(last - first) * sizeof *alone->samples) == 0);
      EXPECT(memcmp(shared->samples_low, alone->samples_low, sizeof alone->samples_low) == 0);
      EXPECT(memcmp(shared->samples_high, alone->samples_high, sizeof alone->samples_high) == 0);
      hc_surface_free(shared);
      hc_surface_free(alone);
    }
}
END_TEST

START_TEST(what_cannot_be_sampled_is_refused_everywhere) {
  hc_surface *const box = surface_of(box_mesh(none, ones));
  hc_error error = {0};
  const hc_parts parts = hc_setup_parts(&comm);
  EXPECT(hc_surface_samples_make(box, 1e-6, 1, false, &parts, &error) == HC_BAD_INPUT);
  EXPECT(strstr(error.text, "is its scale right?") != NULL);
  hc_surface_free(box);
}
END_TEST

/* Two surfaces that cross, and a box that both stand in. */
typedef struct scenery {
  hc_scene scene;
  hc_wall walls[3];
} scenery;

static void make_scenery(scenery *s, hc_comm *ranks) {
  static const double low[3] = {0.4, 0.4, 0.4}, high[3] = {1.2, 1.3, 1.4};
  memset(s, 0, sizeof *s);
  s->scene.particle_spacing = DX;
  s->scene.support_radius = 2 * DX;
  s->scene.boundary.walls = s->walls;
  s->scene.boundary.wall_count = 3;
  s->walls[0].form = s->walls[2].form = HC_FORM_MESH;
  s->walls[0].inside = s->walls[2].inside = HC_INSIDE_SOLID;
  s->walls[1].box = (hc_box){{0, 0, 0.3}, {2, 2, 2}};
  hc_surface *const made[2] = {surface_of(sphere_mesh(ones, 0.5, 3)), surface_of(box_mesh(low, high))};
  for (int k = 0; k < 2; k++) {
    hc_error error;
    const hc_parts parts = hc_setup_parts(ranks);
    EXPECT(hc_surface_samples_make(made[k], DX, 1, false, &parts, &error) == HC_OK);
    s->walls[2 * k].made.surface = made[k];
  }
}

/* Of this rank's particles, whatever their order. */
static int64_t digest(const hc_particles *boundary) {
  uint64_t sum = 0;
  for (int32_t k = 0; k < boundary->own; k++) {
    uint64_t bits = mix(boundary->id[k]);
    for (int a = 0; a < 3; a++) {
      uint32_t normal;
      memcpy(&normal, &boundary->normal[3 * k + a], sizeof normal);
      bits = mix(bits ^ mix((uint64_t)boundary->position[3 * k + a]) ^ normal);
    }
    sum += bits;
  }
  return (int64_t)sum;
}

START_TEST(walls_that_meet_are_one_on_any_number_of_ranks) {
  int64_t counts[2], left_out[2], digests[2] = {0, 0};
  for (int together = 0; together < 2; together++) {
    hc_comm *const ranks = together ? &comm : NULL;
    scenery s;
    hc_setup_plan plan;
    hc_frame frame;
    hc_particles fluid, boundary, moving;
    make_scenery(&s, ranks);
    EXPECT(hc_setup_frame(&s.scene, &frame, NULL) == HC_OK);
    EXPECT(hc_setup_plan_make(ranks, &s.scene, &frame, &plan, NULL) == HC_OK);
    hc_particles_init(&fluid, HC_FLUID, HC_FOR_ALL);
    hc_particles_init(&boundary, HC_BOUNDARY, HC_FOR_ALL);
    hc_particles_init(&moving, HC_BOUNDARY | HC_MOVED, HC_FOR_ALL);
    EXPECT(hc_setup_generate(&plan, comm.rank, comm.size, &fluid, &boundary, &moving, NULL) == HC_OK);
    counts[together] = plan.boundary_count;
    left_out[together] = hc_gaps_total(&plan.boundary[2].gaps);
    digests[together] = digest(&boundary);
    EXPECT(boundary.own <= counts[together] / comm.size + 3 + left_out[together]);
    hc_particles_free(&fluid);
    hc_particles_free(&boundary);
    hc_particles_free(&moving);
    hc_setup_plan_free(&plan);
    hc_surface_free(s.walls[0].made.surface);
    hc_surface_free(s.walls[2].made.surface);
  }
  hc_comm_sum_i64(&comm, digests, 2);
  EXPECT(left_out[0] > 10 && left_out[0] == left_out[1]);
  EXPECT(counts[0] == counts[1] && digests[0] == digests[1]);
}
END_TEST

int main(int argc, char **argv) {
  hc_comm_start(&comm, &argc, &argv);
  TCase *tests = tcase_create("divide");
  tcase_set_timeout(tests, 120);
  tcase_add_test(tests, shares_are_the_whole);
  tcase_add_test(tests, what_cannot_be_sampled_is_refused_everywhere);
  tcase_add_test(tests, walls_that_meet_are_one_on_any_number_of_ranks);
  return run_mpi_tests("divide", tests);
}
