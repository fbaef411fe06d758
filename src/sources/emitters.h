/* Emitters: openings through which fluid comes in at a speed.
 *
 * Particles come in layers, a spacing apart. Layer n is due at start + n spacing / speed; the first step that
 * begins then or later puts it where it would be by then, had it left the opening on time: so a step may
 * bring several layers or none, and the flow does not depend on the steps. A layer is a square lattice cut to
 * the opening. A sample whose place has a fluid particle closer than the clearance is blocked, and left out
 * for good; the owner of the place judges, on the particles before any is added, so that ranks do not matter.
 * Ids count all samples of all layers, left out or not.
 *
 * What has come in so far is state.
 *
 * Known weakness: emitters fill what has room, they do not press; one that opens under water brings in next
 * to nothing. The default clearance, 0.8 spacings: 0.7 lets particles into resting water, which PCISPH does
 * not survive; 0.9 stops slow fountains, whose layers gravity draws together. */
#ifndef HC_EMITTERS_H
#define HC_EMITTERS_H

#include "domain/domain.h"
#include "geometry/shape.h"
#include "space/cells.h"
#include "state/state.h"

typedef struct hc_emitter {
  hc_shape shape;       /* a rectangle: its axes 0 and 1 lie in the opening, axis 2 is the flow's direction */
  double (*samples)[2]; /* of a layer, m along axes 0 and 1 */
  int64_t sample_count;
  double speed, start, stop;        /* m/s, s, s */
  double spacing, clearance;        /* m */
  int64_t limit;                    /* of particles */
  uint64_t source;                  /* in ids */
  int64_t layers, emitted, blocked; /* so far; state */
} hc_emitter;

/* Zeroed: none. */
typedef struct hc_emitters {
  hc_emitter *emitters;
  int count;
} hc_emitters;

void hc_emitters_free(hc_emitters *emitters);

/* Fills a layer with the lattice: of a rectangle of the shape's edges, whole spacings and the rest left over
 * on both sides; of a disc of `radius` (then the shape's edges are not looked at), all samples within it.
 * False if there are more than 2^24. Local. */
bool hc_emitter_sample_rectangle(hc_emitter *emitter);
bool hc_emitter_sample_disc(hc_emitter *emitter, double radius);

/* Layers and particles that come in before `end`, if nothing is blocked. Local. */
double hc_emitter_layers_until(const hc_emitter *emitter, double end);
double hc_emitter_most(const hc_emitter *emitter, double end);

/* Where a sample of a layer is when the layer is `along` (m) from the opening, m. Local. */
void hc_emitter_point(const hc_emitter *emitter, int64_t sample, double along, double x[3]);

/* Registers what has come in so far. Local. */
void hc_emitters_register(hc_emitters *emitters, hc_state *state);

/* The largest speed of an emitter from which a layer is due between `time` and `ahead` later, m/s. Local. */
double hc_emitters_speed(const hc_emitters *emitters, double time, double ahead);

/* Is a layer due at the time? Local. */
bool hc_emitters_due(const hc_emitters *emitters, double time);

/* Brings in the layers that are due. Before: cells sorted, ghosts entered. Returns how many particles all
 * ranks have got together: if any, cells, ghosts and lists are stale, and the new ones are last among the own
 * fluid of the owner of their place. Collective. */
int64_t hc_emitters_release(hc_emitters *emitters, const hc_domain *domain, const hc_cells *cells,
                            hc_particles *fluid, double time);

#endif
