/* When the ranks divide the world anew: looks at how long each has worked, and what a new division would
 * gain.
 *
 * Work is processor time outside the communicator, so that a rank that waits, or shares its core, does not
 * seem busy. At a look, every few steps, the world is divided anew if the imbalance (largest over mean work
 * since the last look) is above parallel.rebalance_above, and what the mean rank would save over the coming
 * steps, as many as the present division has served, is more than the last rebalance cost: as imbalance
 * grows, that comes when what it has cost equals what its mending costs (Menon, Jain, Zheng, Kale 2012,
 * "Automated load balancing invocation based on application characteristics"). Where a new division does not
 * help, looks become rarer. Decisions follow from reduced numbers, so all ranks take the same; they depend on
 * clocks, but what particles do does not depend on them. */
#ifndef HC_BALANCE_H
#define HC_BALANCE_H

#include "scene/scene.h"
#include "world/world.h"

typedef struct hc_balance {
  const hc_scene *scene;       /* the caller's */
  int64_t interval, next_look; /* steps between two looks; the step of the next */
  int64_t last;                /* steps done at the last rebalance, 0 if there was none */
  int64_t divided;             /* the same; -1 if there was none in this session */
  double last_imbalance;       /* measured before it; 0: not to be judged any more */
  double cost; /* the slowest rank's work at the last rebalance, s; 0 before the first, which is free */
  double started, step_work,
      work;                       /* this rank's work: since when, in the last step, since the last look, s */
  int64_t work_steps;             /* since the last look */
  double imbalance;               /* at the last look: largest over mean work */
  int64_t ghosts;                 /* copies of fluid particles on all ranks after the last rebalance */
  int64_t count;                  /* rebalances so far, */
  double seconds, last_seconds;   /* what they, and the last, took of the slowest rank's time, */
  int64_t moved;                  /* and the particles that moved, boundary particles included */
  double largest_work, mean_work; /* summed over the noted steps, s */
} hc_balance;

/* Local. */
void hc_balance_init(hc_balance *balance, const hc_scene *scene);

/* A run that goes on: `step` steps have been done before. Local. */
void hc_balance_go_on(hc_balance *balance, int64_t step);

/* Before the world is placed for a step; `step` steps are done. Collective. */
void hc_balance_look(hc_balance *balance, hc_world *world, int64_t step);

/* Was the world divided anew as this step began? Local. */
bool hc_balance_divided_in(const hc_balance *balance, int64_t step);

/* Around the work of a step, its update included. Local. */
void hc_balance_start(hc_balance *balance, const hc_comm *comm);
void hc_balance_stop(hc_balance *balance, const hc_comm *comm);

/* Takes note of a step's work, reduced over all ranks, and returns its imbalance. Local. */
double hc_balance_note(hc_balance *balance, double largest, double mean);

/* Largest over mean work, over all steps noted. Local. */
double hc_balance_mean_imbalance(const hc_balance *balance);

/* The divider that a scene wants first, and for rebalances. */
hc_divider hc_balance_first_divider(const hc_scene *scene);
hc_divider hc_balance_divider(const hc_scene *scene);

#endif
