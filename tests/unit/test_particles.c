/* The particle store and the table of its fields. */
#include "base/memory.h"
#include "particles/ids.h"
#include "particles/particles.h"

#include <check.h>
#include <stdlib.h>
#include <string.h>

enum { KINDS = 3 };
static const unsigned kinds[KINDS] = {HC_FLUID, HC_BOUNDARY, HC_BOUNDARY | HC_MOVED};

static bool has(unsigned kind, int field) {
  return (hc_fields[field].flags & kind) != 0;
}
static bool is_carried(unsigned kind, int field) {
  return has(kind, field) && (hc_fields[field].flags & HC_CARRIED);
}
static bool has_ghosts(unsigned kind, int field) {
  return has(kind, field) && hc_field_has_ghosts(&hc_fields[field], HC_FOR_ALL);
}

/* Bytes of a field that tell which particle and which field they are. */
static unsigned char expected_byte(int field, uint64_t particle, size_t byte) {
  uint64_t mixed = (particle * 64 + (uint64_t)field) * 32 + byte + 1;
  mixed = (mixed ^ mixed >> 15) * 0xbf58476d1ce4e5b9;
  return (unsigned char)(mixed >> 56);
}

static void fill(hc_particles *particles, int field, int32_t index, uint64_t particle) {
  const size_t bytes = hc_fields[field].bytes;
  unsigned char *to = (unsigned char *)particles->data[field] + (size_t)index * bytes;
  for (size_t k = 0; k < bytes; k++) to[k] = expected_byte(field, particle, k);
}

static bool holds(const hc_particles *particles, int field, int32_t index, uint64_t particle) {
  const size_t bytes = hc_fields[field].bytes;
  const unsigned char *from = (const unsigned char *)particles->data[field] + (size_t)index * bytes;
  bool good = true;
  for (size_t k = 0; k < bytes; k++) good &= from[k] == expected_byte(field, particle, k);
  return good;
}

static bool is_zero(const hc_particles *particles, int field, int32_t index) {
  const size_t bytes = hc_fields[field].bytes;
  const unsigned char *from = (const unsigned char *)particles->data[field] + (size_t)index * bytes;
  bool good = true;
  for (size_t k = 0; k < bytes; k++) good &= from[k] == 0;
  return good;
}

static void fill_all(hc_particles *particles, int32_t begin, int32_t end) {
  for (int field = 0; field < HC_FIELD_COUNT; field++)
    for (int32_t k = begin; k < end && has(particles->kind, field); k++)
      fill(particles, field, k, (uint64_t)k);
}

static bool carried_holds(const hc_particles *particles, int32_t begin, int32_t end) {
  bool good = true;
  for (int field = 0; field < HC_FIELD_COUNT; field++)
    for (int32_t k = begin; k < end && is_carried(particles->kind, field); k++)
      good &= holds(particles, field, k, (uint64_t)k);
  return good;
}

static bool carried_is_zero(const hc_particles *particles, int32_t begin, int32_t end) {
  bool good = true;
  for (int field = 0; field < HC_FIELD_COUNT; field++)
    for (int32_t k = begin; k < end && is_carried(particles->kind, field); k++)
      good &= is_zero(particles, field, k);
  return good;
}

START_TEST(table_makes_sense) {
  static const size_t sizes[] = {
      [HC_TYPE_i64] = 8, [HC_TYPE_u64] = 8, [HC_TYPE_f64] = 8, [HC_TYPE_f32] = 4, [HC_TYPE_record] = 16};
  ck_assert_uint_eq(sizeof(hc_record), 16);
  for (int field = 0; field < HC_FIELD_COUNT; field++) {
    const hc_field_info *info = &hc_fields[field];
    ck_assert(info->name[0] && info->unit[0] && info->sentence[0]);
    ck_assert(info->components >= 1 && info->bytes == (size_t)info->components * sizes[info->type]);
    ck_assert_msg(info->flags & (HC_FLUID | HC_BOUNDARY | HC_MOVED), "%s belongs to nobody", info->name);
    ck_assert_msg(!(info->flags & HC_SNAPSHOT) || info->type != HC_TYPE_record, "%s is packed", info->name);
    for (int other = 0; other < field; other++) ck_assert_str_ne(info->name, hc_fields[other].name);
  }
  ck_assert_str_eq(hc_fields[HC_FIELD_position].name, "position");
  for (int k = 0; k < KINDS; k++) {
    ck_assert(is_carried(kinds[k], HC_FIELD_position) && is_carried(kinds[k], HC_FIELD_id));
    ck_assert(has_ghosts(kinds[k], HC_FIELD_place));
    size_t state = 0, carried = 0;
    for (int field = 0; field < HC_FIELD_COUNT; field++) {
      if (is_carried(kinds[k], field)) carried += hc_fields[field].bytes;
      if (has(kinds[k], field) && hc_field_is_state(&hc_fields[field])) state += hc_fields[field].bytes;
    }
    hc_particles particles;
    hc_particles_init(&particles, kinds[k], HC_FOR_ALL);
    ck_assert_uint_eq(hc_particles_state_bytes(kinds[k], HC_FOR_ALL), state);
    ck_assert_uint_eq(hc_particles_block_bytes(&particles), carried);
    hc_particles_free(&particles);
  }
}
END_TEST

START_TEST(a_store_has_the_fields_of_its_kind) {
  for (int k = 0; k < KINDS; k++) {
    hc_particles particles;
    hc_particles_init(&particles, kinds[k], HC_FOR_ALL);
    ck_assert(particles.own == 0 && particles.ghosts == 0 && particles.border == 0);
    hc_particles_resize(&particles, 3);
    for (int field = 0; field < HC_FIELD_COUNT; field++)
      ck_assert((particles.data[field] != NULL) == has(kinds[k], field));
    ck_assert_ptr_eq(particles.position, particles.data[HC_FIELD_position]);
    ck_assert_ptr_eq(particles.volume, particles.data[HC_FIELD_volume]);
    ck_assert_ptr_eq(particles.place, particles.data[HC_FIELD_place]);
    ck_assert((uintptr_t)particles.place % HC_ALIGNMENT == 0);
    hc_particles_free(&particles);
    hc_particles_free(&particles); /* an empty store may be freed */
  }
}
END_TEST

START_TEST(resizing_keeps_state_and_zeroes_what_is_new) {
  static const int32_t sizes[] = {0, 1, 100, 101, 5000, 4999, 17, 300, 0, 300, 20000, 19000, 20000};
  for (int k = 0; k < KINDS; k++) {
    hc_particles particles;
    hc_particles_init(&particles, kinds[k], HC_FOR_ALL);
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
      const int32_t old = particles.own, now = sizes[s], kept = old < now ? old : now;
      particles.border = old / 2;
      hc_particles_resize(&particles, now);
      ck_assert(particles.own == now && particles.border == 0 && particles.ghosts == 0);
      ck_assert_msg(carried_holds(&particles, 0, kept), "state lost from %d to %d", old, now);
      ck_assert_msg(carried_is_zero(&particles, kept, now), "no zeroes from %d to %d", old, now);
      fill_all(&particles, 0, now);
    }
    hc_particles_free(&particles);
  }
}
END_TEST

START_TEST(ghosts_leave_own_values_alone) {
  static const int32_t counts[] = {0, 5, 3000, 10, 100000, 0};
  for (int k = 0; k < KINDS; k++) {
    hc_particles particles;
    hc_particles_init(&particles, kinds[k], HC_FOR_ALL);
    hc_particles_resize(&particles, 500);
    fill_all(&particles, 0, 500);
    particles.border = 77;
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
      const int32_t all = 500 + counts[c];
      hc_particles_set_ghosts(&particles, counts[c]);
      ck_assert(particles.own == 500 && particles.ghosts == counts[c] && particles.border == 77);
      bool good = true;
      for (int field = 0; field < HC_FIELD_COUNT; field++) {
        if (!has(kinds[k], field)) continue;
        for (int32_t i = 0; i < 500; i++) good &= holds(&particles, field, i, (uint64_t)i);
        if (!has_ghosts(kinds[k], field)) continue;
        for (int32_t i = 500; i < all; i++) fill(&particles, field, i, (uint64_t)i);
        for (int32_t i = all; i < all + HC_SPARE; i++) good &= is_zero(&particles, field, i);
      }
      ck_assert_msg(good, "%d ghosts", counts[c]);
    }
    hc_particles_set_ghosts(&particles, 9);
    hc_particles_resize(&particles, 501);
    ck_assert(particles.ghosts == 0 && particles.border == 0);
    ck_assert(carried_holds(&particles, 0, 500) && carried_is_zero(&particles, 500, 501));
    hc_particles_free(&particles);
  }
}
END_TEST

/* The spare elements of a store of any size are the store's own memory: a sanitizer would tell. */
START_TEST(spare_elements_can_be_read) {
  volatile unsigned char seen = 0;
  for (int32_t own = 0; own < 70; own++) {
    hc_particles particles;
    hc_particles_init(&particles, HC_FLUID, HC_FOR_ALL);
    for (int ghosts = -1; ghosts < 3; ghosts++) {
      if (ghosts < 0)
        hc_particles_resize(&particles, own);
      else
        hc_particles_set_ghosts(&particles, ghosts);
      const size_t end = (size_t)(own + particles.ghosts + HC_SPARE);
      ck_assert(particles.capacity[HC_FIELD_place] >= end && particles.capacity[HC_FIELD_motion] >= end);
      const unsigned char *last = (const unsigned char *)(particles.place + end) - 1;
      seen ^= *last;
      last = (const unsigned char *)(particles.motion + end) - 1;
      seen ^= *last;
    }
    hc_particles_free(&particles);
  }
}
END_TEST

/* A stride that is coprime to the count makes a permutation without fixed order. */
START_TEST(permuting_moves_all_of_a_particle) {
  enum { COUNT = 997 };
  static int32_t order[COUNT];
  for (int32_t k = 0; k < COUNT; k++) order[k] = (int32_t)((int64_t)(k + 5) * 613 % COUNT);
  for (int k = 0; k < KINDS; k++) {
    static const int32_t taken[] = {COUNT, 400, 0}; /* of which some take a part only */
    for (int t = 0; t < 3; t++) {
      hc_particles particles;
      hc_particles_init(&particles, kinds[k], HC_FOR_ALL);
      hc_particles_resize(&particles, COUNT);
      fill_all(&particles, 0, COUNT);
      hc_particles_permute(&particles, order, taken[t]);
      ck_assert_int_eq(particles.own, taken[t]);
      bool good = true;
      for (int field = 0; field < HC_FIELD_COUNT; field++)
        for (int32_t i = 0; i < taken[t] && is_carried(kinds[k], field); i++)
          good &= holds(&particles, field, i, (uint64_t)order[i]);
      ck_assert(good);
      hc_particles_free(&particles);
    }
  }
}
END_TEST

/* Of any size: nothing may be thrown together at the ends of what is moved at once. */
START_TEST(permuting_works_for_any_size) {
  for (int32_t count = 0; count < 40; count++)
    for (int k = 0; k < KINDS; k++) {
      int32_t order[40];
      for (int32_t i = 0; i < count; i++) order[i] = count % 2 ? count - 1 - i : (i + count / 2) % count;
      hc_particles particles;
      hc_particles_init(&particles, kinds[k], HC_FOR_ALL);
      hc_particles_resize(&particles, count);
      fill_all(&particles, 0, count);
      hc_particles_permute(&particles, order, count);
      for (int field = 0; field < HC_FIELD_COUNT; field++)
        for (int32_t i = 0; i < count && is_carried(kinds[k], field); i++)
          ck_assert(holds(&particles, field, i, (uint64_t)order[i]));
      hc_particles_free(&particles);
    }
}
END_TEST

START_TEST(packed_particles_come_back_elsewhere) {
  for (int k = 0; k < KINDS; k++) {
    hc_particles from, to;
    hc_particles_init(&from, kinds[k], HC_FOR_ALL);
    hc_particles_init(&to, kinds[k], HC_FOR_ALL);
    hc_particles_resize(&from, 50);
    hc_particles_resize(&to, 50);
    fill_all(&from, 0, 50);
    const size_t bytes = hc_particles_block_bytes(&from);
    unsigned char *block = hc_alloc(bytes + 1, 1);
    for (int32_t i = 0; i < 50; i += 2) {
      block[bytes] = 0xa5;
      hc_particles_pack(&from, i, block);
      ck_assert_uint_eq(block[bytes], 0xa5);
      hc_particles_unpack(&to, 49 - i, block);
    }
    bool good = true;
    for (int field = 0; field < HC_FIELD_COUNT; field++)
      for (int32_t i = 0; i < 50 && is_carried(kinds[k], field); i++)
        good &= i % 2 == 0 ? holds(&to, field, 49 - i, (uint64_t)i) : is_zero(&to, field, 49 - i);
    ck_assert(good && carried_holds(&from, 0, 50));
    hc_free(block);
    hc_particles_free(&from);
    hc_particles_free(&to);
  }
}
END_TEST

START_TEST(removed_particles_leave_no_gaps) {
  /* here and there; the last; the first */
  static const int32_t gone[][7] = {
      {0, 5, 6, 7, 46, 48, 49}, {43, 44, 45, 46, 47, 48, 49}, {0, 1, 2, 3, 4, 5, 6}};
  for (int k = 0; k < KINDS; k++)
    for (int c = 0; c < 3; c++)
      for (int32_t count = 0; count <= 7; count += 7) {
        hc_particles particles;
        hc_particles_init(&particles, kinds[k], HC_FOR_ALL);
        hc_particles_resize(&particles, 50);
        fill_all(&particles, 0, 50);
        hc_particles_remove(&particles, gone[c], count);
        ck_assert_int_eq(particles.own, 50 - count);
        bool seen[50] = {false};
        for (int32_t i = 0; i < particles.own; i++)
          for (uint64_t was = 0; was < 50; was++) {
            bool same = true;
            for (int field = 0; field < HC_FIELD_COUNT && same; field++)
              if (is_carried(kinds[k], field)) same = holds(&particles, field, i, was);
            seen[was] |= same;
          }
        for (int32_t was = 0; was < 50; was++) {
          bool taken = false;
          for (int32_t g = 0; g < count; g++) taken |= gone[c][g] == was;
          ck_assert(seen[was] == !taken);
        }
        hc_particles_free(&particles);
      }
}
END_TEST

START_TEST(scratch_has_room_for_every_own_particle) {
  hc_particles particles;
  hc_particles_init(&particles, HC_FLUID, HC_FOR_ALL);
  for (int32_t own = 0; own < 2000; own += 333) {
    hc_particles_resize(&particles, own);
    fill_all(&particles, 0, own);
    memset(hc_particles_scratch(&particles, 40), 0xff, (size_t)own * 40);
    ck_assert(carried_holds(&particles, 0, own));
  }
  hc_particles_free(&particles);
}
END_TEST

/* ---- joined stores ---- */

typedef struct joined {
  hc_particles head, tail;
} joined;

static void joined_init(joined *j) {
  hc_particles_init(&j->head, HC_BOUNDARY, HC_FOR_ALL);
  hc_particles_init(&j->tail, HC_BOUNDARY | HC_MOVED, HC_FOR_ALL);
  hc_particles_join(&j->head, &j->tail);
}

static void joined_free(joined *j) {
  hc_particles_free(&j->tail);
  hc_particles_free(&j->head);
}

static bool is_record(int field) {
  return hc_fields[field].type == HC_TYPE_record;
}

/* One behind the other in one array, and behind both spare elements. */
static bool stands_behind(const joined *j) {
  const int32_t first = j->head.own + j->head.ghosts, end = first + j->tail.own + j->tail.ghosts;
  bool good = hc_particles_first(&j->tail) == first && hc_particles_first(&j->head) == 0;
  for (int field = 0; field < HC_FIELD_COUNT; field++) {
    if (!is_record(field) || !has(HC_BOUNDARY, field)) continue;
    good &= j->tail.data[field] == (hc_record *)j->head.data[field] + first;
    good &= j->head.capacity[field] >= (size_t)end + HC_SPARE;
    for (int32_t i = end; i < end + HC_SPARE; i++) good &= is_zero(&j->head, field, i);
  }
  return good;
}

static void fill_records(hc_particles *particles, uint64_t first) {
  for (int field = 0; field < HC_FIELD_COUNT; field++)
    for (int32_t i = 0; i < particles->own + particles->ghosts && is_record(field) && particles->data[field];
         i++)
      fill(particles, field, i, first + (uint64_t)i);
}

/* Are the records of the first `count` those they were filled with? */
static bool records_hold(const hc_particles *particles, int32_t count, uint64_t first) {
  bool good = true;
  for (int field = 0; field < HC_FIELD_COUNT; field++)
    for (int32_t i = 0; i < count && is_record(field) && particles->data[field]; i++)
      good &= holds(particles, field, i, first + (uint64_t)i);
  return good;
}

START_TEST(joined_stores_share_their_records) {
  static const int32_t sizes[][4] = {/* own and ghosts of the head, of the tail */
                                     {0, 0, 5, 0},    {3, 0, 5, 2},     {3, 4, 0, 0},     {100, 7, 1, 1},
                                     {99, 0, 300, 0}, {20000, 5, 7, 9}, {1, 0, 30000, 3}, {0, 0, 0, 0}};
  enum { TAIL = 1000000 };
  joined j;
  joined_init(&j);
  ck_assert(stands_behind(&j));
  for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
    const int32_t *size = sizes[s], head = size[0] + size[1];
    hc_particles_resize(&j.head, size[0]);
    fill_records(&j.head, 0);
    hc_particles_set_ghosts(&j.head, size[1]);
    ck_assert(stands_behind(&j) && records_hold(&j.head, size[0], 0));
    fill_all(&j.head, 0, size[0]);
    fill_records(&j.head, 0);
    hc_particles_resize(&j.tail, size[2]);
    ck_assert(stands_behind(&j) && records_hold(&j.head, head, 0));
    fill_all(&j.tail, 0, size[2]);
    fill_records(&j.tail, TAIL);
    hc_particles_set_ghosts(&j.tail, size[3]);
    ck_assert(stands_behind(&j) && records_hold(&j.head, head, 0) && records_hold(&j.tail, size[2], TAIL));
    fill_records(&j.tail, TAIL);
    hc_particles_set_ghosts(&j.tail, size[3] + 500);
    ck_assert(stands_behind(&j) && records_hold(&j.head, head, 0) && records_hold(&j.tail, size[2], TAIL));
    ck_assert(carried_holds(&j.head, 0, size[0]) && carried_holds(&j.tail, 0, size[2]));
  }
  joined_free(&j);
}
END_TEST

/* What is no record is each store's own, whatever becomes of the other. */
START_TEST(joined_stores_keep_the_rest_apart) {
  static const int32_t sizes[] = {400, 10, 0, 3000, 401};
  joined j;
  joined_init(&j);
  hc_particles_resize(&j.head, 400);
  fill_all(&j.head, 0, 400);
  for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
    hc_particles_resize(&j.tail, sizes[s]);
    fill_all(&j.tail, 0, sizes[s]);
    hc_particles_resize(&j.head, 400 + 100 * (int32_t)s);
    ck_assert(carried_holds(&j.tail, 0, sizes[s]) && carried_holds(&j.head, 0, 400));
    for (int field = 0; field < HC_FIELD_COUNT; field++)
      ck_assert((j.tail.data[field] != NULL) == has(HC_BOUNDARY | HC_MOVED, field));
  }
  joined_free(&j);
}
END_TEST

/* ---- features ---- */

START_TEST(a_store_has_the_fields_that_a_run_needs) {
  for (int k = 0; k < KINDS; k++)
    for (unsigned features = 0; features <= HC_FOR_ALL; features++) {
      hc_particles particles;
      hc_particles_init(&particles, kinds[k], features);
      hc_particles_resize(&particles, 3);
      hc_particles_set_ghosts(&particles, 2);
      size_t all = 0, state = 0, carried = 0;
      for (int field = 0; field < HC_FIELD_COUNT; field++) {
        const hc_field_info *info = &hc_fields[field];
        const bool there = has(kinds[k], field) && (info->needs == 0 || (info->needs & features));
        ck_assert_msg((particles.data[field] != NULL) == there, "%s with features %u", info->name, features);
        all += there ? info->bytes : 0;
        state += there && hc_field_is_state(info) ? info->bytes : 0;
        carried += there && (info->flags & HC_CARRIED) ? info->bytes : 0;
      }
      ck_assert_uint_eq(hc_particles_bytes(kinds[k], features), all);
      ck_assert_uint_eq(hc_particles_state_bytes(kinds[k], features), state);
      ck_assert_uint_eq(hc_particles_block_bytes(&particles), carried);
      const int32_t order[3] = {2, 0, 1};
      hc_particles_permute(&particles, order, 3);
      hc_particles_remove(&particles, order + 1, 1);
      ck_assert_int_eq(particles.own, 2);
      hc_particles_free(&particles);
    }
}
END_TEST

/* By name, so that a wrong row of the table is seen. */
START_TEST(a_solver_carries_nothing_of_another) {
  hc_particles dfsph, pcisph;
  hc_particles_init(&dfsph, HC_FLUID, HC_FOR_DFSPH | HC_FOR_WALL_VOLUMES);
  hc_particles_init(&pcisph, HC_FLUID, HC_FOR_PCISPH | HC_FOR_RIGID_WALLS);
  ck_assert(dfsph.pressure_multiplier && dfsph.divergence_multiplier && dfsph.alpha && dfsph.wall_gradient);
  ck_assert(!dfsph.push && !dfsph.wall_rate);
  ck_assert(pcisph.push && !pcisph.pressure_multiplier && !pcisph.divergence_multiplier && !pcisph.alpha);
  ck_assert(!pcisph.wall_gradient && !pcisph.wall_density && !pcisph.wall_rate);
  ck_assert(dfsph.velocity && dfsph.density && dfsph.place && dfsph.motion && pcisph.velocity);
  hc_particles_free(&dfsph);
  hc_particles_free(&pcisph);
  hc_particles volumes, rigid;
  hc_particles_init(&volumes, HC_BOUNDARY, HC_FOR_DFSPH | HC_FOR_WALL_VOLUMES);
  hc_particles_init(&rigid, HC_BOUNDARY, HC_FOR_PCISPH | HC_FOR_RIGID_WALLS);
  ck_assert(!volumes.boundary_share && rigid.facing && rigid.boundary_share);
  hc_particles_free(&volumes);
  hc_particles_free(&rigid);
}
END_TEST

START_TEST(ids_keep_their_parts_apart) {
  const uint64_t last_source = HC_ID_MAX_SOURCES - 1, last_counter = HC_ID_MAX_COUNTER - 1;
  ck_assert(hc_id_kind_of(hc_id_make(HC_ID_FLUID, last_source, last_counter)) == HC_ID_FLUID);
  ck_assert(hc_id_kind_of(hc_id_make(HC_ID_BOUNDARY, 0, 0)) == HC_ID_BOUNDARY);
  ck_assert(hc_id_make(HC_ID_FLUID, last_source, last_counter) < hc_id_make(HC_ID_BOUNDARY, 0, 0));
  ck_assert(hc_id_make(HC_ID_FLUID, 1, last_counter) < hc_id_make(HC_ID_FLUID, 2, 0));
  ck_assert_uint_eq(hc_id_make(HC_ID_BOUNDARY, last_source, last_counter),
                    hc_id_make((hc_id_kind)2, 0, 0) - 1);
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("particles");
  TCase *const cases = tcase_create("store");
  tcase_set_timeout(cases, 60);
  tcase_add_test(cases, table_makes_sense);
  tcase_add_test(cases, a_store_has_the_fields_of_its_kind);
  tcase_add_test(cases, resizing_keeps_state_and_zeroes_what_is_new);
  tcase_add_test(cases, ghosts_leave_own_values_alone);
  tcase_add_test(cases, spare_elements_can_be_read);
  tcase_add_test(cases, permuting_moves_all_of_a_particle);
  tcase_add_test(cases, permuting_works_for_any_size);
  tcase_add_test(cases, packed_particles_come_back_elsewhere);
  tcase_add_test(cases, removed_particles_leave_no_gaps);
  tcase_add_test(cases, scratch_has_room_for_every_own_particle);
  tcase_add_test(cases, joined_stores_share_their_records);
  tcase_add_test(cases, joined_stores_keep_the_rest_apart);
  tcase_add_test(cases, a_store_has_the_fields_that_a_run_needs);
  tcase_add_test(cases, a_solver_carries_nothing_of_another);
  tcase_add_test(cases, ids_keep_their_parts_apart);
  suite_add_tcase(suite, cases);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
