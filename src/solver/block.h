/* A block of sub-steps under way, see individual.h, and how its particles go on between those in which they
 * are active: lines 8, 9, 18 to 21 of algorithm 2.
 *
 * Positions, velocities, forces and densities of a particle are those of when it was active last; what sweeps
 * see, place and motion, is shown as of now, and only of those that are looked at. Ghosts go on by the same
 * arithmetic from what their owner had then, which is sent once for each time that it was active. */
#ifndef HC_BLOCK_H
#define HC_BLOCK_H

#include "weak.h"

typedef struct hc_individual_settings {
  bool on;
  bool raw;               /* steps as printed, not powers of two */
  bool lasting;           /* lists last for several sub-steps */
  double velocity, force; /* lambda_v, lambda_f of eq. 9 with the support radius */
  double shortest;        /* s: no particle's step may be shorter */
} hc_individual_settings;

/* Of hc_particles.schedule, in ticks. */
enum { HC_LAST, HC_DUE, HC_RAW, HC_SCHEDULE };

typedef struct hc_individual_block {
  hc_world *world;
  const hc_weak_settings *settings;
  const hc_individual_settings *individual;
  double unit;               /* s: of a tick */
  double per_metre[3];       /* units of positions */
  double longest;            /* s: no step of a particle is longer */
  float most;                /* ticks: the raw step of a particle that needs no shorter one than that */
  double calm_v2, calm_a2;   /* it needs none up to these squares of its speed and force */
  double now, next;          /* ticks: of this sub-step and of the one behind it */
  double walls_shown;        /* ticks: where walls that move are shown */
  double walls_fastest;      /* m/s: of them; of this rank's until it is reduced */
  double fastest, strongest; /* m/s, m/s2: largest of particles as they became active, so far */
  double speed;              /* m/s: no particle goes on faster */
  double used;               /* m: by which particles may have moved since they were listed */
  bool exact;                /* lists of all reach no margin: who is active later gets one of its own */
  bool relisted;             /* lists are not those of the block's beginning */
  bool ghosts_new;           /* they know nothing but their places and motions */
  hc_selection active;       /* in this sub-step, and the same as bits in world->chosen */
  int64_t evaluated;         /* active particles so far, but those of the first sub-step */
  int substeps;
  hc_step_report *report;
} hc_individual_block;

static inline float *hc_block_schedule(const hc_individual_block *block, int32_t i) {
  return &block->world->fluid->schedule[HC_SCHEDULE * (size_t)i];
}

/* All own particles and all ghosts are active, and touched. Local. */
void hc_block_activate_all(hc_individual_block *block);

/* Own particles that are due become active: they are chosen, shown, and go on from where they are now. Local.
 */
void hc_block_activate(hc_individual_block *block);

/* Touches active particles, what their lists name, and those that have copies; or, where these are many or
 * `all`, every one. Local. */
void hc_block_touch(hc_individual_block *block, bool all);

bool hc_block_is_active(const hc_individual_block *block, int32_t i); /* ghosts behind own particles */

/* The first touched one of particles [from, end), or end or more. */
static inline int32_t hc_block_touched(const hc_individual_block *block, int32_t from, int32_t end) {
  const uint64_t *const touched = block->world->chosen.touched;
  while (from < end) {
    const uint64_t left = touched[from / 64] >> (from % 64);
    if (left) return from + __builtin_ctzll(left);
    from = (from / 64 + 1) * 64;
  }
  return end;
}
#define HC_FOR_TOUCHED(block, i, from, end)                                                                  \
  for (int32_t i = hc_block_touched(block, from, end); i < (end); i = hc_block_touched(block, i + 1, end))

/* Shows touched particles that are not active; ghosts. Local. */
void hc_block_show_own(const hc_individual_block *block);
void hc_block_show_ghosts(const hc_individual_block *block);

/* Ghosts learn what their owners go on from: new ones all, others what was found of active ones. Collective
 * among partners. */
void hc_block_tell_ghosts(hc_individual_block *block);

/* Ghosts that world->chosen names become active, as their owners have. Local. */
void hc_block_activate_ghosts(const hc_individual_block *block);

/* Densities and pressures of all own particles as they are now. Local. */
void hc_block_fill_pressures(const hc_individual_block *block);

/* Positions of own particles become those of now, `to` 1, or again what they were, -1: both exactly. Local.
 */
void hc_block_shift(const hc_individual_block *block, int to);

/* Shows walls that move where they are now, as they would go on from the block's beginning. Local. */
void hc_block_show_walls(hc_individual_block *block);

#endif
