/* Dividing the world: orders of bricks, the map of intervals, the size of bricks, METIS on graphs of any
 * size, and the numbers of parts. */
#include "base/memory.h"
#include "domain/fringe.h"
#include "domain/graph.h"

#include <check.h>
#include <stdlib.h>
#include <string.h>

static uint64_t state;

/* splitmix64 */
static uint64_t any(void) {
  uint64_t value = state += 0x9e3779b97f4a7c15;
  value = (value ^ value >> 30) * 0xbf58476d1ce4e5b9;
  value = (value ^ value >> 27) * 0x94d049bb133111eb;
  return value ^ value >> 31;
}

static void reset(void) {
  state = 1;
}

/* Bricks near and far, many sharing coordinates. */
static hc_brick any_brick(void) {
  hc_brick brick;
  const int shift = (int)(any() % 30) + 1;
  for (int axis = 0; axis < 3; axis++) brick.x[axis] = (int32_t)(uint32_t)any() >> shift;
  return brick;
}

/* ---- orders ---- */

/* Morton's order by the bits themselves, highest first, z before y before x. */
static int compare_interleaved(const hc_brick *a, const hc_brick *b) {
  for (int bit = 31; bit >= 0; bit--)
    for (int axis = 2; axis >= 0; axis--) {
      const uint32_t p = ((uint32_t)a->x[axis] ^ 0x80000000u) >> bit & 1,
                     q = ((uint32_t)b->x[axis] ^ 0x80000000u) >> bit & 1;
      if (p != q) return p < q ? -1 : 1;
    }
  return 0;
}

START_TEST(morton_order_interleaves_bits) {
  for (int k = 0; k < 20000; k++) {
    const hc_brick a = any_brick();
    hc_brick b = any_brick();
    if (k % 3 == 0) b.x[k % 9 / 3] = a.x[k % 9 / 3];
    ck_assert_int_eq(hc_map_compare(HC_ORDER_MORTON, &a, &b), compare_interleaved(&a, &b));
    ck_assert_int_eq(hc_map_by(HC_ORDER_MORTON)(&a, &b), compare_interleaved(&a, &b));
    ck_assert_int_eq(hc_map_compare(HC_ORDER_MORTON, &a, &a), 0);
  }
}
END_TEST

START_TEST(slab_orders_begin_with_their_axis) {
  const hc_brick low = {{1, 2, 3}};
  for (int order = HC_ORDER_X; order <= HC_ORDER_Z; order++)
    for (int k = 0; k < 3; k++) { /* the axis, then the two that follow */
      hc_brick high = low;
      high.x[(order + k) % 3]++;
      for (int later = k + 1; later < 3; later++) high.x[(order + later) % 3] -= 5;
      ck_assert_int_lt(hc_map_compare((hc_map_order)order, &low, &high), 0);
      ck_assert_int_gt(hc_map_by((hc_map_order)order)(&high, &low), 0);
    }
}
END_TEST

/* ---- the map ---- */

enum { INTERVALS = 300 };

static void make_map(hc_map *map, hc_map_order order, int bits, int ranks) {
  hc_brick first[INTERVALS];
  for (int k = 0; k < INTERVALS; k++) {
    first[k] = any_brick();
    for (int axis = 0; axis < 3; axis++) first[k].x[axis] %= k % 2 ? 40 : 9;
  }
  qsort(first, INTERVALS, sizeof *first, hc_map_by(order));
  hc_map_start(map, order, bits);
  for (int k = 0; k < INTERVALS; k++)
    if (k == 0 || !hc_brick_equal(first[k], first[k - 1]))
      hc_map_add(map, first[k], (int)(any() % (unsigned)ranks));
}

/* The rule itself: the last interval that starts at or before the brick. */
static int owner_by_search(const hc_map *map, hc_brick brick) {
  int32_t found = 0;
  for (int32_t k = 0; k < map->count; k++)
    if (hc_map_compare(map->order, &map->intervals[k].first, &brick) <= 0) found = k;
  return map->intervals[found].rank;
}

START_TEST(the_map_finds_the_last_interval_before) {
  hc_map map;
  hc_map_init(&map, (const int64_t[3]){1000003, -77, 0});
  for (int axis = 0; axis < 3; axis++) ck_assert_int_eq(map.origin[axis] % (1 << HC_MAP_MOST_BITS), 0);
  ck_assert_int_eq(hc_map_owner(&map, any_brick()), 0);
  for (int round = 0; round < 8; round++) {
    make_map(&map, (hc_map_order)(round % 4), round % (HC_MAP_MOST_BITS + 1), 1 + round % 5);
    for (int32_t k = 1; k < map.count; k++) {
      ck_assert_int_ne(map.intervals[k].rank, map.intervals[k - 1].rank);
      ck_assert_int_lt(hc_map_compare(map.order, &map.intervals[k - 1].first, &map.intervals[k].first), 0);
    }
    for (int k = 0; k < 1000; k++) {
      hc_brick brick = any_brick();
      if (k % 2)
        for (int axis = 0; axis < 3; axis++) brick.x[axis] %= 45;
      ck_assert_int_eq(hc_map_owner(&map, brick), owner_by_search(&map, brick));
    }
  }
  hc_map_free(&map);
}
END_TEST

START_TEST(a_box_has_an_owner_only_if_all_its_cells_do) {
  hc_map map;
  hc_map_init(&map, (const int64_t[3]){0, 0, 0});
  int plain = 0;
  for (int round = 0; round < 8; round++) {
    make_map(&map, (hc_map_order)(round % 4), round % 3, 2);
    for (int k = 0; k < 300; k++) {
      int64_t low[3], high[3], cell[3];
      for (int axis = 0; axis < 3; axis++) {
        low[axis] = (int64_t)(any() % 160) - 80;
        high[axis] = low[axis] + (int64_t)(any() % 6);
      }
      const int owner = hc_map_owner_of_box(&map, low, high);
      if (owner == HC_MAP_MIXED) continue;
      plain++;
      for (cell[0] = low[0]; cell[0] <= high[0]; cell[0]++)
        for (cell[1] = low[1]; cell[1] <= high[1]; cell[1]++)
          for (cell[2] = low[2]; cell[2] <= high[2]; cell[2]++)
            ck_assert_int_eq(hc_map_owner(&map, hc_map_brick(&map, map.bits, cell)), owner);
    }
  }
  ck_assert_int_gt(plain, 700);
  hc_map_free(&map);
}
END_TEST

START_TEST(bricks_end_where_their_numbers_do) {
  hc_map map;
  hc_map_init(&map, (const int64_t[3]){64, 0, -64});
  const int64_t cell[3] = {(int64_t)1 << 33, -((int64_t)1 << 33), -65};
  const hc_brick small = hc_map_brick(&map, 0, cell), large = hc_map_brick(&map, 5, cell);
  ck_assert(small.x[0] == INT32_MAX && small.x[1] == INT32_MIN && small.x[2] == -1);
  ck_assert(large.x[0] == (1 << 28) - 2 && large.x[1] == -(1 << 28) && large.x[2] == -1);
  hc_map_free(&map);
}
END_TEST

START_TEST(bricks_are_as_large_as_balance_allows) {
  const int64_t counts[HC_MAP_MOST_BITS + 1] = {32000, 4000, 500, 65, 8, 1};
  ck_assert_int_eq(hc_loads_choose_bits(counts, 1), 3);
  ck_assert_int_eq(hc_loads_choose_bits(counts, 2), 2);
  ck_assert_int_eq(hc_loads_choose_bits(counts, 7), 2);
  ck_assert_int_eq(hc_loads_choose_bits(counts, 8), 1);
  ck_assert_int_eq(hc_loads_choose_bits(counts, 500), 0);
  ck_assert_int_eq(hc_loads_choose_bits(counts, 100000), 0); /* fewer bricks than ranks */
  const int64_t none[HC_MAP_MOST_BITS + 1] = {0};
  ck_assert_int_eq(hc_loads_choose_bits(none, 1), 0);
}
END_TEST

/* ---- bricks, graph, parts ---- */

/* A box of bricks with fluid and loads of random ranks; a brick in five lies on two ranks. */
static hc_load *make_loads(const int edges[3], int ranks, int64_t *count) {
  hc_load *loads = hc_alloc((size_t)edges[0] * (size_t)edges[1] * (size_t)edges[2] * 2, sizeof *loads);
  *count = 0;
  for (int32_t z = 0; z < edges[2]; z++)
    for (int32_t y = 0; y < edges[1]; y++)
      for (int32_t x = 0; x < edges[0]; x++)
        for (int copy = 0; copy < (any() % 5 == 0 ? 2 : 1); copy++) {
          const int32_t fluid = 40 + (int32_t)(any() % 20);
          loads[(*count)++] = (hc_load){.brick = {{x, y, z}},
                                        .weight = (float)(HC_COST_FLUID * fluid),
                                        .fluid = fluid,
                                        .boundary = 3,
                                        .rank = (int32_t)(any() % (unsigned)ranks)};
        }
  return loads;
}

/* A graph for METIS as a run would make it, and what it is made of. */
typedef struct subject {
  hc_map map;
  hc_frame frame;
  hc_load *loads;
  hc_bricks bricks;
  hc_graph graph;
  int32_t *part;
} subject;

static void subject_init(subject *s, const int edges[3], int ranks, bool periodic) {
  memset(s, 0, sizeof *s);
  hc_map_init(&s->map, (const int64_t[3]){0, 0, 0});
  hc_map_start(&s->map, HC_ORDER_MORTON, 1);
  for (int axis = 0; axis < 3; axis++) s->frame.period[axis] = periodic ? 2 * edges[axis] * HC_CELL_UNITS : 0;
  int64_t count;
  s->loads = make_loads(edges, ranks, &count);
  hc_bricks_init(&s->bricks, s->loads, count, HC_ORDER_MORTON);
  hc_graph_init(&s->graph, &s->bricks, &s->map, &s->frame);
  s->part = hc_alloc((size_t)s->bricks.count, sizeof *s->part);
}

static void subject_free(subject *s) {
  hc_free(s->part);
  hc_graph_free(&s->graph);
  hc_bricks_free(&s->bricks);
  hc_free(s->loads);
  hc_map_free(&s->map);
}

START_TEST(the_graph_joins_bricks_that_share_a_face) {
  for (int periodic = 0; periodic < 2; periodic++) {
    const int edges[3] = {5, 2, 1};
    subject s;
    subject_init(&s, edges, 2, periodic);
    ck_assert_int_eq(s.bricks.count, 10);
    for (int32_t k = 0; k < s.bricks.count; k++)
      for (int32_t other = 0; other < s.bricks.count; other++) {
        const hc_loaded_brick *a = &s.bricks.brick[k], *b = &s.bricks.brick[other];
        int faces = 0;
        for (int axis = 0; axis < 3; axis++)
          for (int step = -1; step <= 1; step += 2) {
            hc_brick next = a->brick;
            next.x[axis] += step;
            if (periodic) next.x[axis] = (next.x[axis] + edges[axis]) % edges[axis];
            faces += k != other && hc_brick_equal(next, b->brick);
          }
        int entries = 0;
        for (idx_t entry = s.graph.start[k]; entry < s.graph.start[k + 1]; entry++) {
          if (s.graph.adjacent[entry] != other) continue;
          entries++; /* half of the particles of both lie at the face */
          const double ghosts = 0.5 * (double)(16 * (a->fluid + b->fluid) + a->boundary + b->boundary);
          ck_assert_int_eq(s.graph.edge_weight[entry], faces * (idx_t)(ghosts + 0.5));
        }
        ck_assert_int_eq(entries, faces > 0);
      }
    subject_free(&s);
  }
}
END_TEST

/* The vertex of a brick. */
static idx_t vertex_of(const hc_graph *graph, int32_t brick) {
  for (idx_t v = 0; v < graph->count; v++)
    if (brick >= graph->first[v] && brick < graph->first[v + 1]) return v;
  return -1;
}

/* Bricks of one cube that are not beside water are one vertex, wet ones their own; edges add up faces. */
START_TEST(walls_far_from_water_are_merged) {
  enum { WET = 3 };
  for (int periodic = 0; periodic < 2; periodic++) {
    const int edges[3] = {11, 5, 1};
    subject s;
    subject_init(&s, edges, 2, periodic);
    for (int32_t k = 0; k < s.bricks.count; k++)
      if (s.bricks.brick[k].brick.x[0] >= WET) s.bricks.brick[k].fluid = 0;
    hc_graph_free(&s.graph);
    hc_graph_init(&s.graph, &s.bricks, &s.map, &s.frame);
    int64_t edge_sum = 0, face_sum = 0, weight = 0;
    int wet = 0;
    for (int32_t k = 0; k < s.bricks.count; k++) {
      const hc_loaded_brick *a = &s.bricks.brick[k];
      const idx_t v = vertex_of(&s.graph, k);
      weight += (int64_t)a->weight;
      if (a->fluid > 0) {
        wet++;
        ck_assert_int_eq(s.graph.first[v + 1] - s.graph.first[v], 1);
      }
      for (int32_t other = 0; other < s.bricks.count; other++) {
        const hc_loaded_brick *b = &s.bricks.brick[other];
        const bool cube = a->brick.x[0] / HC_GRAPH_MERGED == b->brick.x[0] / HC_GRAPH_MERGED &&
                          a->brick.x[1] / HC_GRAPH_MERGED == b->brick.x[1] / HC_GRAPH_MERGED;
        if (vertex_of(&s.graph, other) == v) {
          ck_assert(k == other || (cube && a->fluid == 0 && b->fluid == 0));
          continue;
        }
        ck_assert(!cube || a->brick.x[0] / HC_GRAPH_MERGED != 1); /* the others lie beside water */
        for (int face = 0; face < 4; face++) {
          hc_brick next = a->brick;
          next.x[face / 2] += face % 2 ? 1 : -1;
          if (periodic) next.x[face / 2] = (next.x[face / 2] + edges[face / 2]) % edges[face / 2];
          if (!hc_brick_equal(next, b->brick)) continue;
          face_sum += (idx_t)(0.5 * (double)(16 * (a->fluid + b->fluid) + a->boundary + b->boundary) + 0.5);
        }
      }
    }
    ck_assert_int_eq(wet, WET * edges[1]);
    ck_assert_int_lt(s.graph.count, s.bricks.count - 15);
    for (idx_t v = 0; v < s.graph.count; v++) {
      weight -= s.graph.vertex_weight[v];
      for (idx_t entry = s.graph.start[v]; entry < s.graph.start[v + 1]; entry++) {
        ck_assert_int_ne(s.graph.adjacent[entry], v);
        edge_sum += s.graph.edge_weight[entry];
      }
    }
    ck_assert_int_eq(weight, 0);
    ck_assert_int_eq(edge_sum, face_sum);
    ck_assert_ptr_nonnull(hc_graph_divide(&s.graph, 2, s.part));
    for (int32_t k = 0; k < s.bricks.count; k++)
      ck_assert_int_eq(s.part[k], s.part[s.graph.first[vertex_of(&s.graph, k)]]);
    subject_free(&s);
  }
}
END_TEST

/* Every graph up to some size, on any number of parts, also more than there are bricks. */
START_TEST(any_graph_can_be_divided) {
  for (int size = 0; size <= 40; size += 1 + size / 6)
    for (int parts = 1; parts <= 48; parts += 1 + parts / 4) {
      const int edges[3] = {size % 3 ? size : size / 3, size % 3 ? 1 : 3, 1};
      subject s;
      subject_init(&s, edges, parts, size % 2);
      ck_assert_ptr_nonnull(hc_graph_divide(&s.graph, parts, s.part));
      for (int32_t k = 0; k < s.bricks.count; k++) ck_assert(s.part[k] >= 0 && s.part[k] < parts);
      const int64_t moving = hc_bricks_renumber(&s.bricks, parts, NULL, NULL, s.part);
      for (int32_t k = 0; k < s.bricks.count; k++) ck_assert(s.part[k] >= 0 && s.part[k] < parts);
      ck_assert_int_eq(moving, hc_bricks_moving(&s.bricks, s.part));
      hc_fringe_fill(&s.map, &s.bricks, &s.graph, s.part);
      for (int32_t k = 0; k < s.bricks.count; k++)
        ck_assert_int_eq(hc_map_owner(&s.map, s.bricks.brick[k].brick), s.part[k]);
      subject_free(&s);
    }
}
END_TEST

/* What is cut between parts whose ranks are on different hosts. */
static int64_t cut_between_hosts(const subject *s, const hc_hosts *hosts) {
  int32_t *host = hc_alloc((size_t)s->bricks.count, sizeof *host);
  for (int32_t k = 0; k < s->bricks.count; k++) host[k] = hosts->of[s->part[k]];
  const int64_t cut = hc_graph_edge_cut(&s->graph, host);
  hc_free(host);
  return cut;
}

/* Parts that neighbour each other come to one host: alike or not, wherever their ranks stand; and stay on it
 * when the world is divided anew. */
START_TEST(neighbours_share_hosts) {
  enum { PARTS = 32 };
  static const int first[][4] = {{8, 16, 24, 32}, {5, 16, 17, 32}, {1, 2, 3, 32}, {32, 32, 32, 32}};
  for (int c = 0; c < 8; c++) {
    int32_t host[PARTS], group[PARTS], of_group[PARTS], members[PARTS] = {0};
    for (int r = 0; r < PARTS; r++) {
      host[r] = 0;
      while (r >= first[c / 2][host[r]]) host[r]++;
    }
    for (int r = 0; c % 2 && r < PARTS; r++) { /* scattered */
      const int other = r * 5 % PARTS;
      const int32_t kept = host[r];
      host[r] = host[other];
      host[other] = kept;
    }
    hc_hosts hosts;
    hc_hosts_make(&hosts, host, PARTS);
    for (int r = 1; r < PARTS; r++) ck_assert(hosts.of[hosts.order[r - 1]] <= hosts.of[hosts.order[r]]);
    subject s;
    subject_init(&s, (const int[3]){24, 16, 12}, PARTS, false);
    ck_assert_ptr_nonnull(hc_graph_divide(&s.graph, PARTS, s.part));
    int32_t *anywhere = hc_alloc((size_t)s.bricks.count, sizeof *anywhere), *const part = s.part;
    memcpy(anywhere, part, (size_t)s.bricks.count * sizeof *anywhere);
    hc_graph_group(&s.graph, PARTS, s.part, &hosts, group);
    for (int p = 0; p < PARTS; p++) members[group[p]]++;
    for (int h = 0; h < hosts.count; h++) ck_assert_int_eq(members[h], hosts.size[h]);
    for (int p = 0; p < PARTS; p++) of_group[p] = -1;
    const int64_t moving = hc_bricks_renumber(&s.bricks, PARTS, &hosts, group, s.part);
    ck_assert_int_eq(moving, hc_bricks_moving(&s.bricks, s.part));
    int32_t rank_of[PARTS], part_of[PARTS];
    for (int p = 0; p < PARTS; p++) rank_of[p] = part_of[p] = -1;
    for (int32_t k = 0; k < s.bricks.count; k++) {
      const int32_t was = anywhere[k], is = s.part[k], at = hosts.of[is];
      ck_assert(rank_of[was] < 0 || rank_of[was] == is);
      ck_assert(part_of[is] < 0 || part_of[is] == was);
      rank_of[was] = is;
      part_of[is] = was;
      ck_assert(of_group[group[was]] < 0 || of_group[group[was]] == at);
      of_group[group[was]] = at;
    }
    const int64_t cut = cut_between_hosts(&s, &hosts);
    s.part = anywhere;
    hc_bricks_renumber(&s.bricks, PARTS, NULL, NULL, s.part);
    const int64_t usual = cut_between_hosts(&s, &hosts);
    ck_assert_msg(hosts.count == 1 ? cut == 0 && usual == 0 : cut < usual, "case %d: %lld, %lld", c,
                  (long long)cut, (long long)usual);
    s.part = part;
    hc_free(anywhere);
    hc_hosts_free(&hosts);
    subject_free(&s);
  }
}
END_TEST

START_TEST(divisions_are_balanced_and_cut_little) {
  for (int parts = 2; parts <= 32; parts *= 2) {
    subject s;
    subject_init(&s, (const int[3]){24, 16, 12}, parts, false);
    ck_assert_ptr_nonnull(hc_graph_divide(&s.graph, parts, s.part));
    ck_assert_double_le(hc_bricks_imbalance(&s.bricks, parts, s.part), 1.03);
    const int64_t cut = hc_graph_edge_cut(&s.graph, s.part);
    hc_bricks slabs;
    hc_bricks_init(&slabs, s.loads, s.bricks.load_count, HC_ORDER_X);
    hc_bricks_cut(&slabs, parts, s.part);
    ck_assert_double_le(hc_bricks_imbalance(&slabs, parts, s.part), 1.03);
    hc_graph graph;
    hc_graph_init(&graph, &slabs, &s.map, &s.frame);
    ck_assert_int_le(cut, hc_graph_edge_cut(&graph, s.part) * 21 / 20);
    hc_graph_free(&graph);
    hc_bricks_free(&slabs);
    subject_free(&s);
  }
}
END_TEST

/* The best of all numberings, found by trying. */
static int64_t least_moving(const hc_bricks *bricks, int parts, const int32_t *part, int32_t *rank_of,
                            int known) {
  if (known == parts) {
    int64_t moving = 0;
    for (int32_t k = 0; k < bricks->count; k++)
      for (int32_t l = bricks->brick[k].first; l < bricks->brick[k + 1].first; l++)
        if (bricks->load[l].rank != rank_of[part[k]])
          moving += bricks->load[l].fluid + bricks->load[l].boundary;
    return moving;
  }
  int64_t least = INT64_MAX;
  for (int32_t rank = 0; rank < parts; rank++) {
    bool taken = false;
    for (int k = 0; k < known; k++) taken |= rank_of[k] == rank;
    if (taken) continue;
    rank_of[known] = rank;
    const int64_t moving = least_moving(bricks, parts, part, rank_of, known + 1);
    if (moving < least) least = moving;
  }
  return least;
}

START_TEST(parts_are_numbered_so_that_little_moves) {
  enum { PARTS = 5 };
  for (int round = 0; round < 8; round++) {
    subject s;
    subject_init(&s, (const int[3]){9, 5, 3}, PARTS, false);
    int64_t all = 0;
    for (int32_t k = 0; k < s.bricks.count; k++) {
      s.part[k] = (int32_t)(any() % PARTS);
      const bool stays = any() % 100 < (unsigned)(3 * round); /* the more, the later the round */
      for (int32_t l = s.bricks.brick[k].first; l < s.bricks.brick[k + 1].first; l++) {
        if (stays) s.loads[l].rank = (s.part[k] + 2) % PARTS;
        all += s.loads[l].fluid + s.loads[l].boundary;
      }
    }
    int32_t rank_of[PARTS];
    const int64_t least = least_moving(&s.bricks, PARTS, s.part, rank_of, 0);
    int32_t *before = hc_alloc((size_t)s.bricks.count, sizeof *before);
    memcpy(before, s.part, (size_t)s.bricks.count * sizeof *before);
    const int64_t moving = hc_bricks_renumber(&s.bricks, PARTS, NULL, NULL, s.part);
    ck_assert_int_ge(moving, least);
    ck_assert_int_ge(2 * (all - moving), all - least);
    if (round > 10) ck_assert_int_eq(moving, least);
    for (int32_t k = 0; k < s.bricks.count; k++) /* the same parts */
      for (int32_t other = 0; other < s.bricks.count; other++)
        ck_assert((before[k] == before[other]) == (s.part[k] == s.part[other]));
    hc_free(before);
    subject_free(&s);
  }
}
END_TEST

/* Empty bricks beside fluid belong to the part they lie beside. */
START_TEST(the_fringe_goes_with_its_neighbours) {
  subject s;
  subject_init(&s, (const int[3]){12, 4, 4}, 2, false);
  for (int32_t k = 0; k < s.bricks.count; k++) s.part[k] = s.bricks.brick[k].brick.x[0] < 5;
  hc_fringe_fill(&s.map, &s.bricks, &s.graph, s.part);
  for (int32_t x = 0; x < 12; x++)
    for (int32_t y = 0; y < 4; y++)
      for (int32_t above = 4; above < 6; above++) {
        ck_assert_int_eq(hc_map_owner(&s.map, (hc_brick){{x, y, above}}), x < 5);
        ck_assert_int_eq(hc_map_owner(&s.map, (hc_brick){{x, -1, y}}), x < 5);
      }
  subject_free(&s);
}
END_TEST

int main(void) {
  Suite *suite = suite_create("division");
  TCase *tests = tcase_create("division");
  tcase_add_checked_fixture(tests, reset, NULL);
  tcase_set_timeout(tests, 60);
  tcase_add_test(tests, morton_order_interleaves_bits);
  tcase_add_test(tests, slab_orders_begin_with_their_axis);
  tcase_add_test(tests, the_map_finds_the_last_interval_before);
  tcase_add_test(tests, a_box_has_an_owner_only_if_all_its_cells_do);
  tcase_add_test(tests, bricks_end_where_their_numbers_do);
  tcase_add_test(tests, bricks_are_as_large_as_balance_allows);
  tcase_add_test(tests, the_graph_joins_bricks_that_share_a_face);
  tcase_add_test(tests, walls_far_from_water_are_merged);
  tcase_add_test(tests, any_graph_can_be_divided);
  tcase_add_test(tests, neighbours_share_hosts);
  tcase_add_test(tests, divisions_are_balanced_and_cut_little);
  tcase_add_test(tests, parts_are_numbered_so_that_little_moves);
  tcase_add_test(tests, the_fringe_goes_with_its_neighbours);
  suite_add_tcase(suite, tests);
  SRunner *runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
