#include "balance.h"

#include "comm/tally.h"

#include <math.h>
#include <string.h>

enum { SHORTEST_INTERVAL = 10, LONGEST_INTERVAL = 640 };

/* A division that leaves more than this share of the imbalance before it has not helped. */
static const double HELPED = 0.98;

hc_divider hc_balance_first_divider(const hc_scene *scene) {
  return scene->parallel.decomposition == HC_DECOMPOSITION_METIS ? HC_DIVIDER_METIS : HC_DIVIDER_SLABS;
}

hc_divider hc_balance_divider(const hc_scene *scene) {
  switch (scene->parallel.rebalance) {
  case HC_REBALANCE_METIS:
    return HC_DIVIDER_METIS;
  case HC_REBALANCE_SLABS:
    return HC_DIVIDER_SLABS;
  case HC_REBALANCE_NONE:
    break; /* the test hooks still ask */
  }
  return hc_balance_first_divider(scene);
}

void hc_balance_init(hc_balance *balance, const hc_scene *scene) {
  memset(balance, 0, sizeof *balance);
  balance->scene = scene;
  balance->interval = balance->next_look = SHORTEST_INTERVAL;
  balance->imbalance = 1.0;
  balance->divided = -1;
}

void hc_balance_go_on(hc_balance *balance, int64_t step) {
  balance->last = step;
  balance->next_look = step + balance->interval;
}

void hc_balance_start(hc_balance *balance, const hc_comm *comm) {
  balance->started = hc_comm_busy_seconds(comm);
}

void hc_balance_stop(hc_balance *balance, const hc_comm *comm) {
  balance->step_work = hc_comm_busy_seconds(comm) - balance->started;
  balance->work += balance->step_work;
  balance->work_steps++;
}

double hc_balance_note(hc_balance *balance, double largest, double mean) {
  balance->largest_work += largest;
  balance->mean_work += mean;
  return mean > 0.0 ? largest / mean : 1.0;
}

double hc_balance_mean_imbalance(const hc_balance *balance) {
  return balance->mean_work > 0.0 ? balance->largest_work / balance->mean_work : 1.0;
}

/* Reduces the work since the last look: the imbalance, and seconds a step that balance would save. */
static double measure(hc_balance *balance, hc_comm *comm) {
  int64_t largest = (int64_t)(1e9 * balance->work), total = largest;
  hc_tally tally = {.count = 0};
  hc_tally_max_i64(&tally, &largest, 1);
  hc_tally_sum_i64(&tally, &total, 1);
  hc_tally_reduce(comm, &tally);
  const double mean = (double)total / comm->size;
  balance->imbalance = mean > 0.0 ? (double)largest / mean : 1.0;
  return balance->work_steps > 0 ? 1e-9 * ((double)largest - mean) / (double)balance->work_steps : 0.0;
}

static void divide(hc_balance *balance, hc_world *world, int64_t step) {
  hc_comm *comm = world->comm;
  double took[2] = {-hc_seconds(), -hc_comm_busy_seconds(comm)};
  hc_world_rebalance(world, hc_balance_divider(balance->scene), balance->work);
  took[0] += hc_seconds();
  took[1] += hc_comm_busy_seconds(comm);
  hc_comm_max_f64(comm, took, 2);
  balance->last_seconds = took[0];
  balance->cost = took[1];
  balance->seconds += took[0];
  balance->moved += world->division.moving;
  balance->count++;
  balance->last = balance->divided = step;
  balance->last_imbalance = balance->imbalance;
}

/* Looks become rarer while rebalances do not help, and as frequent as before when one has; false if the last
 * one has just been found not to. It is judged soon after, before imbalance can have grown again. */
static bool judge(hc_balance *balance) {
  if (balance->last_imbalance == 0.0) return true;
  const bool helped = balance->imbalance < HELPED * balance->last_imbalance;
  balance->last_imbalance = 0.0;
  if (helped)
    balance->interval = SHORTEST_INTERVAL;
  else if (balance->interval < LONGEST_INTERVAL)
    balance->interval *= 2;
  return helped;
}

void hc_balance_look(hc_balance *balance, hc_world *world, int64_t step) {
  const hc_scene *scene = balance->scene;
  const int64_t at = scene->parallel.rebalance_at, every = scene->parallel.rebalance_every;
  const bool forced = (at > 0 && step == at) || (every > 0 && step > 0 && step % every == 0);
  const bool due = scene->parallel.rebalance != HC_REBALANCE_NONE && step >= balance->next_look;
  if (!forced && !due) return;
  hc_stopwatch_enter(&world->watch, HC_STAGE_BALANCE);
  const double saved = measure(balance, world->comm);
  const bool helped = judge(balance);
  const double gain = saved * (double)(step - balance->last);
  const bool worth =
      due && helped && balance->imbalance > scene->parallel.rebalance_above && gain > balance->cost;
  if (forced || worth) divide(balance, world, step);
  balance->next_look = step + (forced || worth ? SHORTEST_INTERVAL : balance->interval);
  balance->work = 0.0;
  balance->work_steps = 0;
}

bool hc_balance_divided_in(const hc_balance *balance, int64_t step) {
  return balance->divided >= 0 && balance->divided == step - 1;
}
