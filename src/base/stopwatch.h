/* Where a run's time goes: one clock that is always in exactly one stage. */
#ifndef HC_STOPWATCH_H
#define HC_STOPWATCH_H

#include "timer.h"

typedef enum hc_stage {
  HC_STAGE_SETUP,
  HC_STAGE_BALANCE,
  HC_STAGE_MIGRATE,
  HC_STAGE_SORT,
  HC_STAGE_HALO,
  HC_STAGE_BIRTHS, /* and deaths: emitters, walls that absorb, a window that is filled */
  HC_STAGE_LISTS,
  HC_STAGE_DENSITY,
  HC_STAGE_DIVERGENCE,
  HC_STAGE_FORCES,
  HC_STAGE_PRESSURE,
  HC_STAGE_STEPS, /* individual ones: who is active, for how long, and how the others go on */
  HC_STAGE_MOVE,
  HC_STAGE_OUTPUT,
  HC_STAGE_COUNT
} hc_stage;

typedef struct hc_stopwatch {
  double seconds[HC_STAGE_COUNT];
  double since;
  hc_stage stage;
} hc_stopwatch;

static inline void hc_stopwatch_start(hc_stopwatch *watch) {
  *watch = (hc_stopwatch){.since = hc_seconds(), .stage = HC_STAGE_SETUP};
}

/* Ends the current stage and enters the next. */
static inline void hc_stopwatch_enter(hc_stopwatch *watch, hc_stage stage) {
  const double now = hc_seconds();
  watch->seconds[watch->stage] += now - watch->since;
  watch->since = now;
  watch->stage = stage;
}

const char *hc_stage_name(hc_stage stage);

#endif
