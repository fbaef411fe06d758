/* Rest states at their places: what of them stays, and how it comes to rest there (Carensac et al. 2023,
 * section 3). */
#ifndef HC_REST_H
#define HC_REST_H

#include "relax.h"
#include "rest_choice.h"

typedef struct hc_rest_report {
  hc_rest_chosen chosen;
  hc_relaxed relaxed;
  int64_t removed;           /* of what was loaded, air not counted */
  double choosing, relaxing; /* s: of this rank */
} hc_rest_report;

/* Fits `fresh` particles, which have just been put into the fluid's store with their air, to what
 * is there: chooses who stays, takes out the others and all air, and lets candidates come to rest beside the
 * rest, which does not move. Collective. Before: walls have their volumes, bodies are posed. After: particles
 * are with their owners, cells and lists are stale, and world->fluid_total is right. HC_FAILED, agreed, if a
 * damped step, of dt, fails. */
hc_status hc_rest_fit(const hc_resting *resting, const hc_scene_rest *rules, double dt,
                      const hc_rest_fresh *fresh, hc_rest_report *report, hc_error *error);

#endif
