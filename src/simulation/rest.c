#include "rest.h"

#include "base/memory.h"
#include "base/timer.h"
#include "particles/ids.h"

#include <string.h>

/* Particles put aside, as they are packed. */
typedef struct aside {
  char *blocks;
  hc_rest_part *part;
  int32_t count;
  size_t bytes; /* of one */
} aside;

/* Takes all that stays out of the store. */
static aside put_aside(hc_particles *fluid, hc_rest_part *part) {
  aside all = {.part = part, .bytes = hc_particles_block_bytes(fluid)};
  all.blocks = hc_alloc((size_t)fluid->own, all.bytes);
  for (int32_t i = 0; i < fluid->own; i++) {
    if (part[i] == HC_REST_GONE) continue;
    hc_particles_pack(fluid, i, all.blocks + (size_t)all.count * all.bytes);
    part[all.count++] = part[i];
  }
  hc_particles_resize(fluid, 0);
  return all;
}

/* Puts those parts from `least` to `most` behind what the store holds. */
static void put_back(hc_particles *fluid, const aside *all, hc_rest_part least, hc_rest_part most) {
  int32_t count = 0, at = fluid->own;
  for (int32_t k = 0; k < all->count; k++) count += all->part[k] >= least && all->part[k] <= most;
  hc_particles_resize(fluid, at + count);
  for (int32_t k = 0; k < all->count; k++)
    if (all->part[k] >= least && all->part[k] <= most)
      hc_particles_unpack(fluid, at++, all->blocks + (size_t)k * all->bytes);
}

/* The others may not move; they are copies of what is put aside. */
static void hold_others(hc_particles *fluid, const aside *all) {
  int32_t at = 0;
  for (int32_t k = 0; k < all->count; k++) {
    if (all->part[k] < HC_REST_BEHIND) continue;
    if (all->part[k] != HC_REST_CANDIDATE) fluid->id[at] = hc_id_as(fluid->id[at], HC_ID_HELD);
    at++;
  }
}

static void drop_held(hc_particles *fluid) {
  int32_t *const held = hc_alloc((size_t)fluid->own, sizeof *held);
  int32_t found = 0;
  for (int32_t i = 0; i < fluid->own; i++)
    if (hc_id_kind_of(fluid->id[i]) == HC_ID_HELD) held[found++] = i;
  if (found) hc_particles_remove(fluid, held, found);
  hc_free(held);
}

/* Damped steps of the candidates, in a world that holds only them and what is near. */
static hc_status stabilise(const hc_resting *resting, const hc_scene_rest *rules, double dt, const aside *all,
                           hc_rest_report *report, hc_error *error) {
  const hc_relaxing how = {.dt = dt,
                           .steps = rules->steps,
                           .damping_start = rules->damping_start,
                           .damping_end = rules->damping_end,
                           .speed_max = rules->speed_max,
                           .speed_avg = rules->speed_avg,
                           .density_error_avg = rules->density_error_avg,
                           .iterations = rules->iterations};
  hc_world *const world = resting->world;
  hc_particles *const fluid = world->fluid;
  put_back(fluid, all, HC_REST_BEHIND, HC_REST_CANDIDATE);
  hold_others(fluid, all);
  hc_world_count_fluid(world);
  hc_relax(resting, &how, &report->relaxed, error);
  hc_domain_migrate(&world->domain, fluid);
  drop_held(fluid);
  return error->status;
}

hc_status hc_rest_fit(const hc_resting *resting, const hc_scene_rest *rules, double dt,
                      const hc_rest_fresh *fresh, hc_rest_report *report, hc_error *error) {
  hc_world *const world = resting->world;
  const double begun = hc_seconds();
  memset(report, 0, sizeof *report);
  hc_domain_forget_partners(&world->domain);
  hc_world_place(world);
  hc_bodies_touch(resting->bodies, world);
  hc_rest_part *const part = hc_alloc((size_t)world->fluid->own, sizeof *part);
  hc_rest_choose(resting, rules, fresh, part, &report->chosen);
  const int64_t total = world->fluid_total;
  aside all = put_aside(world->fluid, part);
  const double chosen = hc_seconds();
  report->choosing = chosen - begun;
  if (report->chosen.candidates > 0 && rules->steps > 0)
    stabilise(resting, rules, dt, &all, report, error);
  else
    put_back(world->fluid, &all, HC_REST_CANDIDATE, HC_REST_CANDIDATE);
  put_back(world->fluid, &all, HC_REST_AWAY, HC_REST_BESIDE);
  hc_world_count_fluid(world);
  report->removed = total - report->chosen.air - world->fluid_total;
  report->relaxing = hc_seconds() - chosen;
  hc_free(all.blocks);
  hc_free(part);
  hc_domain_forget_partners(&world->domain);
  return error->status;
}
