/* What a run will be, before it is one: its particles exactly, its first step exactly, its memory and its
 * files about.
 *
 * Particles: all of them are made, a few at a time, and counted; nothing is derived from volumes.
 *
 * Memory, of the rank that needs most, at its highest, bytes: PROGRAM + (FLUID + NEIGHBORS (h/spacing)^3) f +
 * WALL b + GHOST g + WRITING min(f + b, one slice of a snapshot). f and b are the fluid and boundary
 * particles of a rank that has its share of the load (as the balance weighs it) times the imbalance that
 * starts a rebalance, and as much of it in walls as there are: a slab with little fluid in it holds the more
 * wall. g are the particles within a support radius of the faces of a slab and of periodic borders, from the
 * extents at the start. The constants stand in estimate.c. Measured on the scenes at hand, from 1,000 to
 * 240,000 particles on 1 and 3 ranks, with the libraries of Debian 12: within 13 %. Known weakness: PROGRAM
 * is mostly the MPI library's, which may take more elsewhere; spray costs more than a body of water.
 *
 * Emitters: f counts what they will have brought at the end, evenly spread.
 *
 * Files: snapshots are as many as asked for, or fewer where steps are longer than their interval; a
 * snapshot's size is right to a few per cent, its packed columns take next to nothing. The tables are counted
 * for the least number of steps. */
#ifndef HC_ESTIMATE_H
#define HC_ESTIMATE_H

#include "halocline/error.h"
#include "scene/scene.h"
#include "setup/limits.h"
#include "setup/prescribed.h"
#include "stepping/time_step.h"

/* What an emitter brings. */
typedef struct hc_estimate_emitter {
  int64_t samples, most;  /* of a layer; particles until the end, if nothing is blocked or the limit is met */
  double speed, rate;     /* m/s; m3/s: what its layers make */
  double low[3], high[3]; /* m: the samples, as a layer comes in */
} hc_estimate_emitter;

/* Some particles and the smallest box around their centres. */
typedef struct hc_estimate_set {
  int64_t count;
  double low[3], high[3]; /* m; count 0: infinities */
} hc_estimate_set;

typedef struct hc_estimate {
  hc_estimate_set fluid, boundary, all;
  hc_estimate_set *blocks, *walls; /* as fluid.blocks, and walls and bodies, of the scene */
  hc_estimate_emitter *emitters;   /* as fluid.emitters */
  int64_t fluid_most;              /* fluid particles at the end, emitters' included */
  hc_estimate_set *swept; /* walls that move: all places that they come to until the end; count 0: stands */
  double limits_low[3], limits_high[3]; /* m: of the world; infinite where there are none */
  double first_step;                    /* s, exactly what run takes */
  hc_step_bound bound;                  /* what bounds it */
  int64_t steps;                        /* at least, */
  bool steps_exact;                     /* or just as many */
  int64_t ranks;
  double memory, memory_program, memory_fluid, memory_boundary, memory_ghosts, memory_writing; /* bytes */
  int64_t snapshots;                                                                           /* at most */
  double snapshot_bytes;
  double checkpoint_bytes; /* of one */
  double
      output_bytes; /* in all at the end, with one checkpoint, or as many as are kept if they come by steps */
} hc_estimate;

/* Estimates a run on so many ranks; freed with hc_estimate_free. HC_BAD_INPUT: the scene's particles cannot
 * be made, or not on so few ranks; then nothing needs freeing. Local; time grows with the particles, memory
 * does not. */
hc_status hc_estimate_make(const hc_scene *scene, int64_t ranks, hc_estimate *estimate, hc_error *error);
void hc_estimate_free(hc_estimate *estimate);

#endif
