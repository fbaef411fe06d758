/* What refreshes and folds bring, against what follows from ids alone: any fields at once, some or all
 * particles, across ranks and periodic borders. */
#include "halo_world.h"

#include <stdlib.h>

/* Records as words, whatever they mean. */
enum { WORDS = 4, SCALAR = 3, RECORDS = 3 };
static const hc_field_id records[RECORDS] = {HC_FIELD_facing, HC_FIELD_place, HC_FIELD_motion};
typedef struct words {
  uint32_t word[WORDS];
} words;

/* A placed world, and who its particles are: records are overwritten. */
typedef struct placed {
  world w;
  uint64_t *id;             /* of own particles and ghosts */
  uint32_t (*shift)[WORDS]; /* what periods add to their places */
  int32_t own, all;
} placed;

static void find_shifts(placed *p) {
  uint32_t(*low)[3] = hc_alloc((size_t)p->w.all_count, sizeof *low);
  for (int32_t k = 0; k < p->w.all_count; k++) /* ids are 0, 1, ... */
    for (int axis = 0; axis < 3; axis++) low[p->w.all[k].id][axis] = (uint32_t)(uint64_t)p->w.all[k].x[axis];
  for (int32_t k = 0; k < p->all; k++)
    for (int axis = 0; axis < 3; axis++)
      p->shift[k][axis] = (uint32_t)p->w.particles.place[k].x[axis] - low[p->id[k]][axis];
  hc_free(low);
}

static void placed_init(placed *p, const region *region, int tag) {
  world_init(&p->w, region, HC_BOUNDARY, tag); /* they have the most records */
  fill(&p->w, region);
  if (tag % 2)
    divide_wildly(&p->w, 1);
  else
    balance(&p->w, HC_DIVIDER_METIS);
  build(&p->w);
  p->own = p->w.particles.own;
  p->all = p->own + p->w.particles.ghosts;
  p->id = hc_alloc((size_t)p->all, sizeof *p->id);
  p->shift = hc_alloc_zero((size_t)p->all, sizeof *p->shift);
  for (int32_t k = 0; k < p->all; k++) p->id[k] = id_of(&p->w, k);
  find_shifts(p);
}

static void placed_free(placed *p) {
  hc_free(p->id);
  hc_free(p->shift);
  world_free(&p->w);
}

static uint32_t value_of(uint64_t id, int round, int record, int word) {
  return (
      uint32_t)(mix(((id * 64 + (uint64_t)round) * RECORDS + (uint64_t)record) * WORDS + (uint64_t)word) >>
                32);
}

static words *words_of(const placed *p, int record, int32_t index) {
  return (words *)p->w.particles.data[records[record]] + index;
}

/* Own particles in [begin, end) have the values of this round. */
static void set_own(placed *p, int32_t begin, int32_t end, int round) {
  for (int record = 0; record < RECORDS; record++)
    for (int32_t k = begin; k < end; k++)
      for (int word = 0; word < WORDS; word++)
        words_of(p, record, k)->word[word] = value_of(p->id[k], round, record, word);
}

/* What ghosts hold before a refresh. */
static uint32_t spoilt(int32_t ghost, int record, int word) {
  return value_of((uint64_t)ghost, 63, record, word);
}
static void spoil_ghosts(placed *p) {
  for (int record = 0; record < RECORDS; record++)
    for (int32_t k = p->own; k < p->all; k++)
      for (int word = 0; word < WORDS; word++) words_of(p, record, k)->word[word] = spoilt(k, record, word);
}

static bool is_in(hc_field_set fields, int record, int word) {
  const hc_field_set whole = (hc_field_set)1 << records[record];
  return (fields & whole) || (word == SCALAR && (fields & whole << 32));
}

/* Is a particle in the random selection of this share of all, in quarters? */
static bool is_chosen(uint64_t id, int quarters, int round) {
  return (int)(mix(id * 31 + (uint64_t)round) >> 62) < quarters;
}

/* Own values are those of the round, and so are ghosts' of chosen particles where the fields say so; others
 * are as they were. */
static bool all_is_right(const placed *p, hc_field_set fields, int round, int quarters) {
  bool good = true;
  for (int record = 0; record < RECORDS; record++)
    for (int32_t k = 0; k < p->all; k++)
      for (int word = 0; word < WORDS; word++) {
        uint32_t expected = value_of(p->id[k], round, record, word);
        if (records[record] == HC_FIELD_place) expected += p->shift[k][word];
        if (k >= p->own && !(is_in(fields, record, word) && is_chosen(p->id[k], quarters, round)))
          expected = spoilt(k, record, word);
        good &= words_of(p, record, k)->word[word] == expected;
      }
  return good;
}

/* One of the sets of whole records and scalars. */
enum { SETS = 1 << (2 * RECORDS), EVERY = 4 };
static hc_field_set set_of(int number) {
  hc_field_set fields = 0;
  for (int record = 0; record < RECORDS; record++) {
    const hc_field_set whole = (hc_field_set)1 << records[record];
    if (number >> record & 1) fields |= whole;
    if (number >> (RECORDS + record) & 1) fields |= whole << 32;
  }
  return fields;
}

START_TEST(any_fields_are_refreshed_at_once) {
  for (int r = 0; r < REGIONS; r++) {
    placed p;
    placed_init(&p, &regions[r], r);
    for (int number = 1; number < SETS; number += r == 3 ? 1 : 5) {
      const hc_field_set fields = set_of(number);
      set_own(&p, 0, p.own, number % 60);
      spoil_ghosts(&p);
      hc_halo_refresh(&p.w.halo, fields);
      EXPECT(all_is_right(&p, fields, number % 60, EVERY));
    }
    placed_free(&p);
  }
}
END_TEST

START_TEST(interior_values_may_change_under_way) {
  const hc_field_set fields = HC_WHOLE(motion) | HC_SCALAR(place);
  for (int r = 0; r < REGIONS; r++) {
    placed p;
    placed_init(&p, &regions[r], r);
    set_own(&p, 0, p.w.particles.border, 1);
    spoil_ghosts(&p);
    hc_halo_begin(&p.w.halo, fields);
    const hc_field_set under_way = p.w.particles.under_way;
    set_own(&p, p.w.particles.border, p.own, 1);
    hc_halo_end(&p.w.halo);
    EXPECT(all_is_right(&p, fields, 1, EVERY));
    EXPECT(under_way == fields && p.w.particles.under_way == 0);
    placed_free(&p);
  }
}
END_TEST

/* Many refreshes of different fields and particles with nothing between them. */
START_TEST(refreshes_keep_their_order) {
  placed p;
  placed_init(&p, &regions[3], 0);
  uint64_t *chosen = hc_alloc_zero((size_t)p.own / 64 + 1, sizeof *chosen);
  bool good = true;
  for (int round = 0; round < 60; round++) {
    const hc_field_set fields = set_of(1 + (int)(mix((uint64_t)round) % (SETS - 1)));
    set_own(&p, 0, p.own, round);
    spoil_ghosts(&p);
    if (round % 3 == 2) {
      hc_halo_begin_some(&p.w.halo, fields, chosen);
      hc_halo_end_some(&p.w.halo, NULL);
    } else {
      hc_halo_refresh(&p.w.halo, fields);
    }
    good &= all_is_right(&p, fields, round, round % 3 == 2 ? 0 : EVERY);
  }
  EXPECT(good);
  hc_free(chosen);
  placed_free(&p);
}
END_TEST

/* ---- of a selection ---- */

/* Of own particles and ghosts. */
static uint64_t *choose(const placed *p, int quarters, int round) {
  uint64_t *chosen = hc_alloc_zero((size_t)p->all / 64 + 1, sizeof *chosen);
  for (int32_t k = 0; k < p->all; k++)
    if (is_chosen(p->id[k], quarters, round)) chosen[k / 64] |= (uint64_t)1 << (k % 64);
  return chosen;
}

static bool selected_is_right(const placed *p, const uint64_t *selected, int quarters, int round) {
  bool good = true;
  for (int32_t k = 0; k < p->all - p->own; k++)
    good &= (selected[k / 64] >> (k % 64) & 1) == is_chosen(p->id[p->own + k], quarters, round);
  return good;
}

START_TEST(some_are_refreshed_and_others_left_alone) {
  static const int sets[] = {1 << 2, 1 << 4, 1 << 1 | 1 << 5, SETS - 1, 1 | 1 << 1 | 1 << 5};
  for (int r = 0; r < REGIONS; r++) {
    placed p;
    placed_init(&p, &regions[r], r);
    uint64_t *selected = hc_alloc((size_t)(p.all - p.own) / 64 + 1, sizeof *selected);
    for (int round = 0; round < 5 * (EVERY + 1); round++) {
      const int quarters = round % (EVERY + 1); /* none, ..., all */
      const hc_field_set fields = set_of(sets[round / (EVERY + 1)]);
      uint64_t *chosen = choose(&p, quarters, round);
      set_own(&p, 0, p.own, round);
      spoil_ghosts(&p);
      memset(selected, 0xa5, ((size_t)(p.all - p.own) / 64 + 1) * sizeof *selected);
      hc_halo_begin_some(&p.w.halo, fields, chosen);
      hc_halo_end_some(&p.w.halo, selected);
      EXPECT(all_is_right(&p, fields, round, quarters));
      EXPECT(selected_is_right(&p, selected, quarters, round));
      hc_free(chosen);
    }
    hc_free(selected);
    placed_free(&p);
  }
}
END_TEST

/* ---- two halos ---- */

/* Both have as many partners as there are, and every rank begins and ends them in an order of its own. */
START_TEST(two_halos_may_be_under_way) {
  placed p[2];
  placed_init(&p[0], &regions[3], 0);
  placed_init(&p[1], &regions[8], 1);
  for (int round = 0; round < 12; round++) {
    const int quarters = round % 3 + 1, first = (comm.rank + round) & 1, ended = (comm.rank + round / 2) & 1;
    const hc_field_set fields[2] = {set_of(1 + round * 5 % (SETS - 1)), set_of(SETS - 1 - round)};
    uint64_t *chosen = choose(&p[1], quarters, round);
    for (int k = 0; k < 2; k++) {
      set_own(&p[k], 0, p[k].own, round);
      spoil_ghosts(&p[k]);
    }
    for (int k = 0; k < 2; k++) {
      if (k == first)
        hc_halo_begin(&p[0].w.halo, fields[0]);
      else
        hc_halo_begin_some(&p[1].w.halo, fields[1], chosen);
    }
    for (int k = 0; k < 2; k++) {
      if (k == ended)
        hc_halo_end(&p[0].w.halo);
      else
        hc_halo_end_some(&p[1].w.halo, NULL);
    }
    EXPECT(all_is_right(&p[0], fields[0], round, EVERY));
    EXPECT(all_is_right(&p[1], fields[1], round, quarters));
    hc_free(chosen);
  }
  for (int k = 0; k < 2; k++) placed_free(&p[k]);
}
END_TEST

/* ---- back to the owner ---- */

enum { MOST_COMPONENTS = 3 };
typedef struct number_kind {
  hc_field_type type;
  int components;
} number_kind;
static const number_kind kinds[] = {{HC_TYPE_f32, 1}, {HC_TYPE_f32, 3}, {HC_TYPE_f64, 3},
                                    {HC_TYPE_f64, 1}, {HC_TYPE_i64, 1}, {HC_TYPE_u64, 2}};
enum { KINDS = sizeof kinds / sizeof *kinds };

static void put(void *values, hc_field_type type, size_t at, double value) {
  if (type == HC_TYPE_f32) ((float *)values)[at] = (float)value;
  if (type == HC_TYPE_f64) ((double *)values)[at] = value;
  if (type == HC_TYPE_i64) ((int64_t *)values)[at] = (int64_t)value;
  if (type == HC_TYPE_u64) ((uint64_t *)values)[at] = (uint64_t)value;
}

static double got(const void *values, hc_field_type type, size_t at) {
  if (type == HC_TYPE_f32) return (double)((const float *)values)[at];
  if (type == HC_TYPE_f64) return ((const double *)values)[at];
  return type == HC_TYPE_i64 ? (double)((const int64_t *)values)[at] : (double)((const uint64_t *)values)[at];
}

/* Every type holds it exactly; of both signs, or up to the end of what has none. */
static double random_of(hc_field_type type, uint64_t seed) {
  const double value = (double)(mix(seed) >> 44);
  return type == HC_TYPE_u64 ? value * 0x1p44 : value - 0x1p19;
}

/* A particle or a copy of it, anywhere, and its values. */
typedef struct holder {
  uint64_t id;
  double value[MOST_COMPONENTS];
} holder;

static const double NOTHING = 0x1p70;

/* Gives own particles and ghosts random values of their own; tells all ranks those that a fold of chosen
 * ghosts (null: of all) looks at. */
static holder *give_values(const placed *p, number_kind kind, int round, const uint64_t *chosen, void *values,
                           size_t *count) {
  holder *mine = hc_alloc_zero((size_t)p->all, sizeof *mine);
  for (int32_t k = 0; k < p->all; k++) {
    mine[k].id = p->id[k];
    for (int c = 0; c < kind.components; c++) {
      const uint64_t seed = ((uint64_t)(comm.rank * 100 + round) << 32) + (uint64_t)(k * MOST_COMPONENTS + c);
      mine[k].value[c] = random_of(kind.type, seed);
      put(values, kind.type, (size_t)(k * kind.components + c), mine[k].value[c]);
      if (k >= p->own && !(chosen[k / 64] >> (k % 64) & 1)) mine[k].value[c] = NOTHING;
    }
  }
  void *all;
  size_t bytes;
  hc_comm_gather_all(&comm, mine, (size_t)p->all * sizeof *mine, &all, &bytes);
  hc_free(mine);
  *count = bytes / sizeof *mine;
  return all;
}

/* Own particles have the least of all that have their id, ghosts what they had. */
static bool fold_is_right(const placed *p, number_kind kind, const void *values, const holder *holders,
                          size_t count, const void *before) {
  holder *least = hc_alloc((size_t)p->w.all_count, sizeof *least);
  for (int32_t k = 0; k < p->w.all_count; k++)
    for (int c = 0; c < MOST_COMPONENTS; c++) least[k].value[c] = NOTHING;
  for (size_t k = 0; k < count; k++)
    for (int c = 0; c < kind.components; c++) {
      double *value = &least[holders[k].id].value[c];
      if (holders[k].value[c] < *value) *value = holders[k].value[c];
    }
  bool good = true;
  for (int32_t k = 0; k < p->all; k++)
    for (int c = 0; c < kind.components; c++) {
      const size_t at = (size_t)(k * kind.components + c);
      good &=
          got(values, kind.type, at) == (k < p->own ? least[p->id[k]].value[c] : got(before, kind.type, at));
    }
  hc_free(least);
  return good;
}

static size_t fold(placed *p, number_kind kind, int round, const uint64_t *chosen) {
  const size_t room = (size_t)p->all * MOST_COMPONENTS * sizeof(double);
  void *values = hc_alloc_zero(room, 1), *before = hc_alloc_zero(room, 1);
  size_t count;
  holder *holders = give_values(p, kind, round, chosen, values, &count);
  memcpy(before, values, room);
  hc_halo_fold_least(&p->w.halo, kind.type, kind.components, values, chosen);
  EXPECT(fold_is_right(p, kind, values, holders, count, before));
  hc_free(holders);
  hc_free(values);
  hc_free(before);
  return count;
}

START_TEST(folds_bring_the_least_of_all_copies) {
  int64_t several = 0; /* copies beyond the first of their particle */
  for (int r = 0; r < REGIONS; r++) {
    placed p;
    placed_init(&p, &regions[r], r);
    uint64_t *everybody = choose(&p, EVERY, 0);
    for (int k = 0; k < KINDS; k++) several += (int64_t)fold(&p, kinds[k], k, everybody) > 2 * p.w.all_count;
    set_own(&p, 0, p.own, 7); /* a refresh after a fold */
    spoil_ghosts(&p);
    hc_halo_refresh(&p.w.halo, HC_WHOLE(motion));
    EXPECT(all_is_right(&p, HC_WHOLE(motion), 7, EVERY));
    hc_free(everybody);
    placed_free(&p);
  }
  ck_assert_int_gt(several, 0);
}
END_TEST

START_TEST(folds_of_some_leave_the_others) {
  const size_t limit = hc_comm_part_limit(&comm);
  for (int r = 0; r < REGIONS; r++) {
    placed p;
    placed_init(&p, &regions[r], r);
    for (int round = 0; round < KINDS * (EVERY + 1); round++) {
      uint64_t *chosen = choose(&p, round % (EVERY + 1), round);
      hc_comm_set_part_limit(&comm, round % 2 ? 100 : limit);
      fold(&p, kinds[round % KINDS], round, chosen);
      hc_free(chosen);
    }
    hc_comm_set_part_limit(&comm, limit);
    placed_free(&p);
  }
}
END_TEST

/* The fewer are chosen, the fewer bytes are sent, there and back. */
START_TEST(what_is_not_chosen_is_not_sent) {
  placed p;
  placed_init(&p, &regions[3], 0);
  int64_t bytes[EVERY + 1];
  for (int quarters = 0; quarters <= EVERY; quarters++) {
    uint64_t *chosen = choose(&p, quarters, 0);
    float *values = hc_alloc_zero((size_t)p.all, sizeof *values);
    const int64_t before = comm.bytes_sent;
    hc_halo_begin_some(&p.w.halo, HC_WHOLE(motion), chosen);
    hc_halo_end_some(&p.w.halo, NULL);
    hc_halo_fold_least(&p.w.halo, HC_TYPE_f32, 1, values, chosen);
    bytes[quarters] = comm.bytes_sent - before;
    hc_free(values);
    hc_free(chosen);
  }
  hc_comm_sum_i64(&comm, bytes, EVERY + 1);
  for (int quarters = 0; quarters < EVERY && comm.size > 1; quarters++)
    ck_assert(bytes[quarters] < bytes[quarters + 1]);
  placed_free(&p);
}
END_TEST

/* A fold of one halo while the other's refresh is under way. */
START_TEST(a_fold_minds_its_own_halo) {
  placed p[2];
  placed_init(&p[0], &regions[3], 0);
  placed_init(&p[1], &regions[4], 1);
  const number_kind kind = {HC_TYPE_f32, 1};
  const size_t room = (size_t)p[1].all * sizeof(float);
  float *values = hc_alloc(room, 1), *before = hc_alloc(room, 1);
  size_t count;
  uint64_t *everybody = choose(&p[1], EVERY, 0);
  holder *holders = give_values(&p[1], kind, 0, everybody, values, &count);
  memcpy(before, values, room);
  set_own(&p[0], 0, p[0].own, 3);
  spoil_ghosts(&p[0]);
  hc_halo_begin(&p[0].w.halo, HC_WHOLE(place));
  hc_halo_fold_least(&p[1].w.halo, kind.type, kind.components, values, everybody);
  hc_halo_end(&p[0].w.halo);
  EXPECT(fold_is_right(&p[1], kind, values, holders, count, before));
  EXPECT(all_is_right(&p[0], HC_WHOLE(place), 3, EVERY));
  hc_free(holders);
  hc_free(everybody);
  hc_free(values);
  hc_free(before);
  for (int k = 0; k < 2; k++) placed_free(&p[k]);
}
END_TEST

int main(int argc, char **argv) {
  hc_comm_start(&comm, &argc, &argv);
  TCase *tests = tcase_create("refreshes");
  tcase_set_timeout(tests, 100);
  tcase_add_test(tests, any_fields_are_refreshed_at_once);
  tcase_add_test(tests, interior_values_may_change_under_way);
  tcase_add_test(tests, refreshes_keep_their_order);
  tcase_add_test(tests, some_are_refreshed_and_others_left_alone);
  tcase_add_test(tests, two_halos_may_be_under_way);
  tcase_add_test(tests, folds_bring_the_least_of_all_copies);
  tcase_add_test(tests, folds_of_some_leave_the_others);
  tcase_add_test(tests, what_is_not_chosen_is_not_sent);
  tcase_add_test(tests, a_fold_minds_its_own_halo);
  return run_mpi_tests("halo_refresh", tests);
}
