/* Lists and sweeps of a selection: a selected particle has the same bits whoever else is selected, the others
 * are left alone; and no sweep reads what is on its way. */
#include "cloud.h"
#include "sph/error_rule.h"

#include <check.h>
#include <signal.h>
#include <stdio.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

typedef enum sweep_id {
  DENSITY,
  WALL_SUMS,
  ERROR,
  ERROR_FROM_RATE,
  ERROR_AND_XSPH,
  PRESSURE,
  XSPH,
  LAMINAR,
  SMAGORINSKY,
  ARTIFICIAL,
  COHESION,
  PREDICTED_DENSITY,
  CORRECTED_DENSITY,
  BOUNDARY_DENSITY, /* the only one that is for boundary particles */
  PUSH,
  CONTACTS,
  PLANE_CONTACTS,
  WALL_VELOCITIES,
  SWEEPS
} sweep_id;

enum { FLUID = 517, WALLS = 150, MOST = FLUID };

static const hc_error_rule rule = {
    .of_density = 1.0f, .of_rate = 0.002f, .signed_error = true, .relaxation = 0.5f};

/* A cloud, and what sweeps write beside the stores. */
typedef struct bench {
  setting s;
  float change[3 * MOST];
  hc_record contacts[MOST], velocities[MOST];
  float weights[HC_WALL_WEIGHTS + 1];
  hc_prediction prediction;
} bench;

static float any(uint64_t seed) {
  return (float)random_number(seed * 3 + 1000003);
}

/* All that a sweep may read has values. */
static void fill_values(bench *b) {
  setting *s = &b->s;
  set_values(s);
  for (int32_t k = 0; k < s->fluid.own; k++) {
    const uint64_t id = s->fluid.id[k];
    s->fluid.pressure[k] = 100.0f * any(id);
    s->fluid.density[k] = 1.0f + 0.1f * any(id + 1);
    s->fluid.motion[k].scalar = 1.0f + 0.1f * any(id + 2);
    s->fluid.alpha[k] = 1e-6f * (2.0f + any(id + 3));
    s->fluid.wall_density[k] = 0.1f + 0.1f * any(id + 4);
    s->fluid.wall_rate[k] = any(id + 5);
    for (int axis = 0; axis < 3; axis++) {
      b->change[3 * k + axis] = any(7 * id + (uint64_t)axis);
      b->contacts[k].v[axis] = b->velocities[k].v[axis] = any(5 * id + (uint64_t)axis);
      s->fluid.push[3 * k + axis] = any(9 * id + (uint64_t)axis);
      s->fluid.wall_gradient[3 * k + axis] = any(11 * id + (uint64_t)axis);
    }
    b->contacts[k].scalar = b->velocities[k].scalar = any(id);
  }
  for (int32_t k = 0; k < s->boundary.own; k++) {
    const uint64_t id = s->boundary.id[k];
    s->boundary.pressure[k] = 50.0f * any(id + 5000);
    s->boundary.boundary_share[k] = 0.4f;
    s->boundary.facing[k] = (hc_record){.v = {0.0f, 0.6f, 0.8f}, .scalar = 0.0f};
  }
}

static void bench_init(bench *b) {
  memset(b, 0, sizeof *b);
  make_cloud(&b->s, FLUID, WALLS);
  b->s.sweep.walls_move = true;
  b->s.sweep.wall_offset = 0.25f;
  b->s.sweep.reach = (float)H / 2;
  for (int k = 0; k <= HC_WALL_WEIGHTS; k++) b->weights[k] = 1.0f - (float)k / HC_WALL_WEIGHTS;
  b->prediction = (hc_prediction){.negative = true, .stiffness = 3.0f, .dt = 1e-3f, .weights = b->weights};
}

static hc_error_total run(bench *b, hc_isa isa, sweep_id id, hc_selection selection) {
  const hc_sweeps *sweeps = hc_sweeps_of(isa);
  const hc_sweep *sweep = &b->s.sweep;
  hc_error_total total;
  memset(&total, 0, sizeof total);
  switch (id) {
  case DENSITY:
    sweeps->density(sweep, selection);
    break;
  case WALL_SUMS:
    sweeps->wall_sums(sweep, selection);
    break;
  case ERROR:
    sweeps->error(sweep, &rule, selection, &total);
    break;
  case ERROR_FROM_RATE:
    sweeps->error_from_rate(sweep, &rule, selection);
    break;
  case ERROR_AND_XSPH:
    sweeps->error_and_xsph(sweep, &rule, selection, &total, &(hc_smoothing){0.05f, b->change});
    break;
  case PRESSURE:
    sweeps->pressure(sweep, 250.0f, b->s.fluid.pressure_multiplier, selection);
    break;
  case XSPH:
    sweeps->xsph(sweep, 0.05f, b->change, selection);
    break;
  case LAMINAR:
    sweeps->laminar(sweep, 3e-5f, b->change, selection);
    break;
  case SMAGORINSKY:
    sweeps->smagorinsky(sweep, &(hc_eddies){.molecular = 0.002f, .scale = 0.005f, .most = 0.011f}, b->change,
                        selection);
    break;
  case ARTIFICIAL:
    sweeps->artificial(sweep, 2e-4f, b->change, selection);
    break;
  case COHESION:
    sweeps->cohesion(sweep, 1e-4f, b->change, selection);
    break;
  case PREDICTED_DENSITY:
    sweeps->predicted_density(sweep, &b->prediction, selection, &total);
    break;
  case CORRECTED_DENSITY:
    sweeps->corrected_density(sweep, &b->prediction, selection, &total);
    break;
  case BOUNDARY_DENSITY:
    sweeps->boundary_density(sweep, &b->prediction, &b->s.boundary, &b->s.wetted, selection);
    break;
  case PUSH:
    sweeps->push(sweep, &b->prediction, selection);
    break;
  case CONTACTS:
    sweeps->contacts(sweep, HC_CONTACT_WEIGHTED, b->contacts, selection);
    break;
  case PLANE_CONTACTS:
    sweeps->contacts(sweep, HC_CONTACT_DISTANCE, b->contacts, selection);
    break;
  case WALL_VELOCITIES:
    sweeps->wall_velocities(sweep, b->velocities, selection);
    break;
  case SWEEPS:
    break;
  }
  return total;
}

/* ---- what particles have ---- */

static hc_particles *targets_of(bench *b, sweep_id id) {
  return id == BOUNDARY_DENSITY ? &b->s.boundary : &b->s.fluid;
}

enum { OUTPUTS = 3 };

/* The arrays that a sweep over these targets may write, with their bytes for each particle. */
static int arrays_of(bench *b, const hc_particles *targets, void *arrays[], size_t bytes[]) {
  int count = 0;
  for (int field = 0; field < HC_FIELD_COUNT; field++) {
    if (!targets->data[field]) continue;
    arrays[count] = targets->data[field];
    bytes[count++] = hc_fields[field].bytes;
  }
  if (targets == &b->s.boundary) return count;
  void *const outputs[OUTPUTS] = {b->change, b->contacts, b->velocities};
  static const size_t sizes[OUTPUTS] = {3 * sizeof(float), sizeof(hc_record), sizeof(hc_record)};
  for (int k = 0; k < OUTPUTS; k++) {
    arrays[count] = outputs[k];
    bytes[count++] = sizes[k];
  }
  return count;
}

/* All that the targets have, particle by particle. */
enum { BLOCK_BYTES = 512 };
typedef unsigned char block[BLOCK_BYTES];

static void look(bench *b, const hc_particles *targets, block *blocks) {
  void *arrays[HC_FIELD_COUNT + OUTPUTS];
  size_t bytes[HC_FIELD_COUNT + OUTPUTS], at = 0;
  const int count = arrays_of(b, targets, arrays, bytes);
  memset(blocks, 0, (size_t)targets->own * sizeof *blocks);
  for (int a = 0; a < count; at += bytes[a++]) {
    ck_assert(at + bytes[a] <= BLOCK_BYTES);
    for (int32_t k = 0; k < targets->own; k++)
      memcpy(blocks[k] + at, (const char *)arrays[a] + (size_t)k * bytes[a], bytes[a]);
  }
}

/* ---- selections ---- */

/* Of every few particles one at random; 1: all, 0: none. */
static int32_t choose(int32_t own, int every, uint64_t seed, int32_t *index) {
  int32_t count = 0;
  for (int32_t k = 0; k < own; k++)
    if (every && mix(seed * 100000 + (uint64_t)k) % (uint64_t)every == 0) index[count++] = k;
  return count;
}

static void build_list(const bench *b, hc_isa isa, hc_neighbors *list, bool of_walls, bool to_walls,
                       hc_selection selection) {
  const setting *s = &b->s;
  hc_neighbor_search search;
  hc_neighbor_search_init(&search, isa);
  hc_neighbors_build(
      list, &search, of_walls ? &s->boundary_cells : &s->cells, of_walls ? &s->boundary : &s->fluid,
      selection,
      &(hc_neighbor_source){to_walls ? &s->boundary_cells : &s->cells, to_walls ? &s->boundary : &s->fluid},
      1);
  hc_neighbor_search_free(&search);
}

/* The lists that sweeps over the targets need. */
static void build_lists(bench *b, hc_isa isa, sweep_id id, hc_selection selection) {
  if (id == BOUNDARY_DENSITY) {
    build_list(b, isa, &b->s.wetted, true, false, selection);
  } else {
    build_list(b, isa, &b->s.list, false, false, selection);
    build_list(b, isa, &b->s.walls, false, true, selection);
  }
}

static bool rows_are_the_same(const hc_neighbors *all, const hc_neighbors *some, hc_selection selection) {
  bool good = some->row[selection.begin] < HC_LIST_GROUP;
  int64_t pairs = 0;
  for (int32_t r = selection.begin; r < selection.end; r++) {
    const int32_t i = hc_selected(selection, r);
    const int32_t entries = hc_list_entries(all, i);
    good &= hc_list_entries(some, r) == entries && hc_list_count(some, r) == hc_list_count(all, i) &&
            memcmp(hc_list_row(some, r), hc_list_row(all, i), (size_t)entries * sizeof *all->offset) == 0;
    pairs += hc_list_count(some, r);
  }
  return good && some->pairs == pairs;
}

static const int every[] = {1, 2, 3, 40, 0};
enum { CHOICES = sizeof every / sizeof *every };

START_TEST(lists_of_a_selection_have_the_same_rows) {
  static bench b;
  bench_init(&b);
  int32_t index[MOST];
  hc_neighbors all, some;
  hc_neighbors_init(&all);
  hc_neighbors_init(&some);
  for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++)
    for (int pair = 0; pair < 4; pair++) { /* fluid and walls into fluid and walls */
      const bool of_walls = pair & 1, to_walls = pair & 2;
      const hc_particles *targets = of_walls ? &b.s.boundary : &b.s.fluid;
      build_list(&b, (hc_isa)isa, &all, of_walls, to_walls, hc_select_all(targets));
      ck_assert_int_gt(all.pairs, 300);
      for (int c = 0; c < CHOICES; c++) {
        const hc_selection selection = {index, 0, choose(targets->own, every[c], (uint64_t)isa, index),
                                        false};
        build_list(&b, (hc_isa)isa, &some, of_walls, to_walls, selection);
        ck_assert_msg(rows_are_the_same(&all, &some, selection), "%s", hc_isa_name((hc_isa)isa));
      }
      const hc_selection range = hc_select_range(0, targets->own / 3);
      build_list(&b, (hc_isa)isa, &some, of_walls, to_walls, range);
      ck_assert(rows_are_the_same(&all, &some, range));
    }
  hc_neighbors_free(&all);
  hc_neighbors_free(&some);
  setting_free(&b.s);
}
END_TEST

/* A selection, in parts and whole, against all. */
static void check_selection(bench *b, hc_isa isa, sweep_id id, hc_selection selection, const block *before,
                            const block *all, block *after) {
  hc_particles *targets = targets_of(b, id);
  build_lists(b, isa, id, selection);
  for (int parts = 0; parts < 2; parts++) {
    fill_values(b);
    if (parts) {
      run(b, isa, id, hc_select_interior(selection, targets));
      run(b, isa, id, hc_select_border(selection, targets));
    } else {
      run(b, isa, id, selection);
    }
    look(b, targets, after);
    int32_t row = selection.begin;
    for (int32_t k = 0; k < targets->own; k++) {
      const bool selected = row < selection.end && hc_selected(selection, row) == k;
      row += selected;
      ck_assert_msg(memcmp(after[k], selected ? all[k] : before[k], sizeof *after) == 0,
                    "%s, sweep %d: particle %d, which is%s selected", hc_isa_name(isa), id, k,
                    selected ? "" : " not");
    }
  }
}

/* Any selection against all, of which the lists are before and afterwards. */
static void check_sweep(bench *b, hc_isa isa, sweep_id id) {
  static block before[MOST], all[MOST], after[MOST];
  int32_t index[MOST];
  hc_particles *targets = targets_of(b, id);
  fill_values(b);
  look(b, targets, before);
  run(b, isa, id, hc_select_all(targets));
  look(b, targets, all);
  ck_assert_msg(memcmp(before, all, (size_t)targets->own * sizeof *all) != 0, "sweep %d does nothing", id);
  for (int c = 0; c < CHOICES; c++) {
    const hc_selection selection = {index, 0, choose(targets->own, every[c], id, index), false};
    check_selection(b, isa, id, selection, before, all, after);
  }
  build_lists(b, isa, id, hc_select_all(targets));
}

static const hc_wall_rule wall_rules[] = {HC_WALLS_MIRRORED, HC_WALLS_PRESSURE, HC_WALLS_DISTANCE,
                                          HC_WALLS_NOTHING};

START_TEST(sweeps_of_a_selection_give_the_same_bits) {
  static bench b;
  bench_init(&b);
  b.s.fluid.border = FLUID / 3;
  b.s.boundary.border = WALLS / 2;
  for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++)
    for (int walls = 0; walls < 4; walls++)
      for (sweep_id id = 0; id < SWEEPS; id++) {
        b.s.sweep.walls_add = wall_rules[walls];
        b.prediction.shepard = false;
        check_sweep(&b, (hc_isa)isa, id);
        b.prediction.shepard = true;
        if (id == PREDICTED_DENSITY) check_sweep(&b, (hc_isa)isa, id);
      }
  setting_free(&b.s);
}
END_TEST

/* The errors of a selection and of the rest add up to those of all. */
START_TEST(totals_of_selections_add_up) {
  static const sweep_id ids[] = {ERROR, ERROR_AND_XSPH, PREDICTED_DENSITY, CORRECTED_DENSITY};
  static bench b;
  bench_init(&b);
  for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++)
    for (int k = 0; k < 4; k++) {
      hc_error_total total[3];
      for (int part = 0; part < 3; part++) {
        int32_t index[MOST];
        hc_selection selection = {index, 0, 0, false};
        for (int32_t i = 0; i < FLUID; i++)
          if (part == 2 || (mix((uint64_t)i) & 1) == (uint64_t)part) index[selection.end++] = i;
        fill_values(&b);
        build_lists(&b, (hc_isa)isa, ids[k], selection);
        total[part] = run(&b, (hc_isa)isa, ids[k], selection);
      }
      ck_assert(total[0].sum + total[1].sum == total[2].sum && total[2].sum > 0);
      ck_assert(fmaxf(total[0].max, total[1].max) == total[2].max);
    }
  setting_free(&b.s);
}
END_TEST

START_TEST(parts_of_a_selection_meet_at_the_border) {
  hc_particles particles;
  hc_particles_init(&particles, HC_FLUID, 0);
  hc_particles_resize(&particles, 100);
  int32_t index[100];
  for (int32_t border = 0; border <= 100; border += 5) {
    particles.border = border;
    for (int e = 0; e < CHOICES; e++)
      for (int indexed = 0; indexed < 2; indexed++) {
        const int32_t count = choose(100, every[e], (uint64_t)border, index);
        const hc_selection whole =
            indexed ? (hc_selection){index, count / 4, count, false} : hc_select_range(7, 90);
        const hc_selection at_border = hc_select_border(whole, &particles),
                           interior = hc_select_interior(whole, &particles);
        ck_assert(at_border.begin == whole.begin && interior.end == whole.end);
        ck_assert(at_border.end == interior.begin && at_border.end >= at_border.begin &&
                  interior.end >= interior.begin);
        for (int32_t r = at_border.begin; r < at_border.end; r++)
          ck_assert_int_lt(hc_selected(whole, r), border);
        for (int32_t r = interior.begin; r < interior.end; r++)
          ck_assert_int_ge(hc_selected(whole, r), border);
      }
  }
  hc_particles_free(&particles);
}
END_TEST

/* ---- what is under way ---- */

/* Does a sweep end the program? */
static bool ends_program(bench *b, hc_isa isa, sweep_id id, hc_selection selection) {
  const pid_t child = fork();
  ck_assert_int_ge(child, 0);
  if (child == 0) {
    const struct rlimit no_core = {0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    if (!freopen("/dev/null", "w", stderr)) _exit(2);
    signal(SIGABRT, SIG_DFL);
    run(b, isa, id, selection);
    _exit(0);
  }
  int status;
  ck_assert(waitpid(child, &status, 0) == child);
  ck_assert(WIFSIGNALED(status) || WEXITSTATUS(status) == 0);
  return WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT;
}

/* Which ghosts' values of the fluid each sweep reads, and whether those of walls. */
static const struct reads {
  hc_field_set fluid;
  bool walls;
} reads[SWEEPS] = {
    [DENSITY] = {HC_WHOLE(place) | HC_WHOLE(motion), true},
    [WALL_SUMS] = {0, true},
    [ERROR] = {HC_WHOLE(place) | HC_WHOLE(motion), false},
    [ERROR_FROM_RATE] = {0, false},
    [ERROR_AND_XSPH] = {HC_WHOLE(place) | HC_WHOLE(motion) | HC_SCALAR(motion), false},
    [PRESSURE] = {HC_WHOLE(place) | HC_SCALAR(place), false},
    [XSPH] = {HC_WHOLE(place) | HC_WHOLE(motion) | HC_SCALAR(motion), false},
    [LAMINAR] = {HC_WHOLE(place) | HC_WHOLE(motion), true},
    [SMAGORINSKY] = {HC_WHOLE(place) | HC_WHOLE(motion), false},
    [ARTIFICIAL] = {HC_WHOLE(place) | HC_WHOLE(motion), true},
    [COHESION] = {HC_WHOLE(place), false},
    [PREDICTED_DENSITY] = {HC_WHOLE(place), true},
    [CORRECTED_DENSITY] = {HC_WHOLE(place) | HC_WHOLE(motion) | HC_SCALAR(motion), true},
    [BOUNDARY_DENSITY] = {HC_WHOLE(place), false},
    [PUSH] = {HC_WHOLE(place) | HC_SCALAR(place), true},
    [CONTACTS] = {0, true},
    [PLANE_CONTACTS] = {0, true},
    [WALL_VELOCITIES] = {0, true},
};

START_TEST(no_sweep_reads_what_is_under_way) {
  static const hc_field_set fields[] = {HC_WHOLE(place), HC_SCALAR(place), HC_WHOLE(motion),
                                        HC_SCALAR(motion)};
  static bench b;
  bench_init(&b);
  fill_values(&b);
  hc_particles *fluid = &b.s.fluid;
  fluid->border = FLUID / 3;
  for (sweep_id id = 0; id < SWEEPS; id++) {
    const hc_selection all = hc_select_all(targets_of(&b, id));
    for (int f = 0; f < 4; f++) {
      fluid->under_way = fields[f];
      if (reads[id].fluid & fields[f])
        ck_assert_msg(ends_program(&b, hc_isa_best(), id, all), "sweep %d reads fields %d", id, f);
      if (id != BOUNDARY_DENSITY) {
        ck_assert_msg(!ends_program(&b, hc_isa_best(), id, hc_select_interior(all, fluid)),
                      "sweep %d has no ghosts to read", id);
        if (reads[id].fluid & fields[f])
          ck_assert(ends_program(&b, hc_isa_best(), id, hc_select_border(all, fluid)));
      }
      ck_assert(!ends_program(&b, hc_isa_best(), id, hc_select_range(0, 0)));
    }
    fluid->under_way = 0;
    ck_assert(!ends_program(&b, hc_isa_best(), id, all));
  }
  setting_free(&b.s);
}
END_TEST

/* Interior particles may be next to ghosts of walls. */
START_TEST(no_sweep_reads_walls_that_are_under_way) {
  static bench b;
  hc_particles moving;
  bench_init(&b);
  fill_values(&b);
  hc_particles_init(&moving, HC_BOUNDARY | HC_MOVED, HC_FOR_ALL);
  for (int of_moving = 0; of_moving < 2; of_moving++) {
    b.s.boundary.tail = of_moving ? &moving : NULL;
    hc_particles *under_way = of_moving ? &moving : &b.s.boundary;
    under_way->under_way = HC_SCALAR(place);
    for (sweep_id id = 0; id < SWEEPS; id++)
      if (reads[id].walls)
        ck_assert_msg(ends_program(&b, hc_isa_best(), id, hc_select_all(&b.s.fluid)), "sweep %d", id);
    under_way->under_way = 0;
  }
  b.s.boundary.tail = NULL;
  hc_particles_free(&moving);
  setting_free(&b.s);
}
END_TEST

/* A run has only the fields that its features name. */
START_TEST(no_sweep_takes_a_field_that_is_not_there) {
  static bench b;
  bench_init(&b);
  fill_values(&b);
  hc_particles *const fluid = &b.s.fluid, *const boundary = &b.s.boundary;
  const struct {
    sweep_id id;
    void **field;
  } needs[] = {{DENSITY, (void **)&fluid->alpha},
               {DENSITY, (void **)&fluid->wall_gradient},
               {DENSITY, (void **)&fluid->wall_density},
               {WALL_SUMS, (void **)&fluid->wall_gradient},
               {WALL_SUMS, (void **)&fluid->wall_density},
               {ERROR, (void **)&fluid->alpha},
               {ERROR, (void **)&fluid->wall_gradient},
               {PRESSURE, (void **)&fluid->wall_gradient},
               {LAMINAR, (void **)&fluid->wall_gradient},
               {BOUNDARY_DENSITY, (void **)&boundary->boundary_share},
               {PUSH, (void **)&fluid->push},
               {CONTACTS, (void **)&boundary->facing},
               {PLANE_CONTACTS, (void **)&boundary->facing}};
  for (size_t k = 0; k < sizeof needs / sizeof *needs; k++) {
    void *const kept = *needs[k].field;
    const hc_selection all = hc_select_all(targets_of(&b, needs[k].id));
    ck_assert(!ends_program(&b, hc_isa_best(), needs[k].id, all));
    *needs[k].field = NULL;
    ck_assert_msg(ends_program(&b, hc_isa_best(), needs[k].id, all), "row %zu", k);
    *needs[k].field = kept;
  }
  setting_free(&b.s);
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("selections");
  TCase *const cases = tcase_create("selections");
  tcase_set_timeout(cases, 60);
  tcase_add_test(cases, lists_of_a_selection_have_the_same_rows);
  tcase_add_test(cases, sweeps_of_a_selection_give_the_same_bits);
  tcase_add_test(cases, totals_of_selections_add_up);
  tcase_add_test(cases, parts_of_a_selection_meet_at_the_border);
  tcase_add_test(cases, no_sweep_reads_what_is_under_way);
  tcase_add_test(cases, no_sweep_reads_walls_that_are_under_way);
  tcase_add_test(cases, no_sweep_takes_a_field_that_is_not_there);
  suite_add_tcase(suite, cases);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
