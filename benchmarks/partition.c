/* Dividing a large synthetic world on one core: time and memory of each stage of a METIS division, what comes
 * out of it, and the price of asking the map.
 *
 * A flat heap of bricks of 2^3 cells with a wavy surface, 64 particles in each, a tenth more in every other
 * column, spread over as many ranks as there are parts by slabs. Usage: bench_partition [BRICKS
 * [PARTS]...]; default: 1,000,000 bricks, 64 256 1024 parts, 64 of them to a host */
#include "base/check.h"
#include "base/memory.h"
#include "base/timer.h"
#include "domain/fringe.h"
#include "domain/graph.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BITS = 1, PARTICLES = 64, LOOKUPS = 1000000, RANKS_PER_HOST = 64 };

/* The loads of a heap of about `wanted` bricks, twice as long and wide as high; *count is how many. */
static hc_load *make_heap(int wanted, int64_t *count) {
  const int height = (int)cbrt(0.25 * wanted), width = 2 * height;
  hc_load *loads = hc_alloc((size_t)width * (size_t)width * (size_t)height * 2, sizeof *loads);
  *count = 0;
  for (int x = 0; x < width; x++)
    for (int y = 0; y < width; y++) {
      const int top = (int)(height * (1.0 + 0.2 * sin(12.0 * x / width) * cos(9.0 * y / width)));
      for (int z = 0; z < top; z++) {
        const int fluid = PARTICLES + (x + y) % 2 * PARTICLES / 10;
        loads[(*count)++] = (hc_load){.brick = {{x, y, z}}, .weight = (float)(48 * fluid), .fluid = fluid};
      }
    }
  return loads;
}

/* Slabs, as a run begins: each load's rank. */
static void spread(hc_load *loads, int64_t count, int parts) {
  hc_bricks bricks;
  hc_bricks_init(&bricks, loads, count, HC_ORDER_X);
  int32_t *part = hc_alloc((size_t)bricks.count, sizeof *part);
  hc_bricks_cut(&bricks, parts, part);
  for (int32_t k = 0; k < bricks.count; k++) loads[k].rank = part[k];
  hc_free(part);
  hc_bricks_free(&bricks);
}

/* The cells (bits x + 2 y + 4 z) of a brick that lie beside the brick in direction `way`. */
static unsigned cells_beside(int way) {
  const int step[3] = {way % 3 - 1, way / 3 % 3 - 1, way / 9 - 1};
  unsigned cells = 0;
  for (int cell = 0; cell < 8; cell++) {
    bool beside = true;
    for (int axis = 0; axis < 3; axis++) beside &= step[axis] == 0 || (cell >> axis & 1) == (step[axis] > 0);
    if (beside) cells |= 1u << cell;
  }
  return cells;
}

/* The share of particles that become ghosts: once for each other part that owns a cell beside theirs; and of
 * these the share on other hosts. */
static double ghost_share(const hc_bricks *bricks, const int32_t *part, const hc_hosts *hosts,
                          double *leaving) {
  hc_brick_set set;
  hc_brick_set_init(&set);
  for (int32_t k = 0; k < bricks->count; k++) hc_brick_set_add(&set, bricks->brick[k].brick);
  double ghosts = 0.0, particles = 0.0, away = 0.0;
  for (int32_t k = 0; k < bricks->count; k++) {
    int32_t seen[HC_ADJACENT];
    unsigned cells[HC_ADJACENT];
    int count = 0;
    for (int way = 0; way < HC_ADJACENT; way++) {
      hc_brick next = bricks->brick[k].brick;
      for (int axis = 0, rest = way; axis < 3; axis++, rest /= 3) next.x[axis] += rest % 3 - 1;
      const int32_t other = hc_brick_set_find(&set, next);
      if (other < 0 || part[other] == part[k]) continue;
      int s = 0;
      while (s < count && seen[s] != part[other]) s++;
      if (s == count) {
        seen[count] = part[other];
        cells[count++] = 0;
      }
      cells[s] |= cells_beside(way);
    }
    for (int s = 0; s < count; s++) {
      const double copies = __builtin_popcount(cells[s]) / 8.0 * (double)bricks->brick[k].fluid;
      ghosts += copies;
      if (hosts->of[seen[s]] != hosts->of[part[k]]) away += copies;
    }
    particles += (double)bricks->brick[k].fluid;
  }
  hc_brick_set_free(&set);
  *leaving = away / ghosts;
  return ghosts / particles;
}

static double lookup_seconds(const hc_map *map, const hc_bricks *bricks) {
  int64_t sum = 0;
  uint32_t any = 1;
  const double start = hc_seconds();
  for (int k = 0; k < LOOKUPS; k++) {
    any = any * 1664525u + 1013904223u;
    sum += hc_map_owner(map, bricks->brick[any % (uint32_t)bricks->count].brick);
  }
  HC_CHECK(sum >= 0, "the sum of ranks is %lld", (long long)sum);
  return (hc_seconds() - start) / LOOKUPS;
}

static void measure(hc_load *loads, int64_t count, int parts) {
  spread(loads, count, parts);
  const hc_frame frame = {.support_radius = 1.0};
  hc_map map;
  hc_map_init(&map, (const int64_t[3]){0, 0, 0});
  hc_map_start(&map, HC_ORDER_MORTON, BITS);
  double times[6];
  times[0] = hc_seconds();
  hc_bricks bricks;
  hc_bricks_init(&bricks, loads, count, HC_ORDER_MORTON);
  int32_t *part = hc_alloc((size_t)bricks.count, sizeof *part);
  times[1] = hc_seconds();
  hc_graph graph;
  hc_graph_init(&graph, &bricks, &map, &frame);
  times[2] = hc_seconds();
  const char *way = hc_graph_divide(&graph, parts, part);
  HC_CHECK(way, "METIS failed on %d parts", parts);
  times[3] = hc_seconds();
  hc_hosts hosts;
  int32_t *host = hc_alloc((size_t)parts, sizeof *host), *group = hc_alloc((size_t)parts, sizeof *group),
          *other = hc_alloc((size_t)bricks.count, sizeof *other);
  for (int r = 0; r < parts; r++) host[r] = r / RANKS_PER_HOST;
  hc_hosts_make(&hosts, host, parts);
  memcpy(other, part, (size_t)bricks.count * sizeof *other);
  const int64_t moving_anywhere = hc_bricks_renumber(&bricks, parts, &hosts, NULL, other);
  double leaving, leaving_anywhere;
  const double ghosts = ghost_share(&bricks, other, &hosts, &leaving_anywhere);
  times[4] = hc_seconds();
  hc_graph_group(&graph, parts, part, &hosts, group);
  const int64_t moving = hc_bricks_renumber(&bricks, parts, &hosts, group, part);
  const double renumbering = hc_seconds() - times[4];
  ghost_share(&bricks, part, &hosts, &leaving);
  hc_free(host);
  hc_free(group);
  hc_free(other);
  times[4] = hc_seconds();
  hc_fringe_fill(&map, &bricks, &graph, part);
  hc_graph_free(&graph);
  times[5] = hc_seconds();
  double particles = 0.0;
  for (int32_t k = 0; k < bricks.count; k++) particles += (double)bricks.brick[k].fluid;
  printf("%5d parts: sort %.3f s, graph %.3f s, metis (%s) %.3f s, renumber %.3f s, map %.3f "
         "s; imbalance "
         "%.3f, ghosts %.1f %%, moving %.1f %%; %d intervals, %.1f KiB, %.2f bytes a brick, lookup %.0f ns; "
         "memory at "
         "most %.0f MiB\n",
         parts, times[1] - times[0], times[2] - times[1], way, times[3] - times[2], renumbering,
         times[5] - times[4], hc_bricks_imbalance(&bricks, parts, part), 100.0 * ghosts,
         100.0 * (double)moving / particles, map.count, (double)map.count * sizeof *map.intervals / 1024.0,
         (double)map.count * sizeof *map.intervals / bricks.count, 1e9 * lookup_seconds(&map, &bricks),
         (double)hc_memory_peak() / 1048576.0);
  printf("        %d hosts: %.1f %% of the ghosts leave theirs, %.1f %% where parts are given to any rank "
         "(moving %.1f %%)\n",
         hosts.count, 100.0 * leaving, 100.0 * leaving_anywhere, 100.0 * (double)moving_anywhere / particles);
  hc_hosts_free(&hosts);
  hc_free(part);
  hc_bricks_free(&bricks);
  hc_map_free(&map);
}

int main(int argc, char **argv) {
  const int bricks = argc > 1 ? atoi(argv[1]) : 1000000;
  if (bricks < 64 || bricks > 100000000) {
    fprintf(stderr, "usage: bench_partition [BRICKS of 64 to 10^8 [PARTS]...]\n");
    return 2;
  }
  int64_t count;
  hc_load *loads = make_heap(bricks, &count);
  printf("%lld bricks, %.0f MiB before\n", (long long)count, (double)hc_memory_peak() / 1048576.0);
  static const int usual[] = {64, 256, 1024};
  for (int k = 0; k < (argc > 2 ? argc - 2 : 3); k++) {
    const int parts = argc > 2 ? atoi(argv[2 + k]) : usual[k];
    if (parts > 0) measure(loads, count, parts);
  }
  hc_free(loads);
  return 0;
}
