/* Fluid particles that come in during a run, before they are in the store; and what is around the places
 * where they are to come. */
#ifndef HC_ARRIVALS_H
#define HC_ARRIVALS_H

#include "space/cells.h"

typedef struct hc_arrival {
  uint64_t id;
  int64_t x[3]; /* wrapped */
  double velocity[3];
} hc_arrival;

/* Zeroed: none. Freed with hc_arrivals_free. */
typedef struct hc_arrivals {
  hc_arrival *at;
  size_t count, room;
} hc_arrivals;

/* The new one, its velocity 0. Local. */
hc_arrival *hc_arrivals_add(hc_arrivals *arrivals, uint64_t id, const int64_t x[3]);

/* Puts them behind the own particles of the store; cells and ghosts are stale then. Local. */
void hc_arrivals_append(const hc_arrivals *arrivals, hc_particles *fluid);
void hc_arrivals_free(hc_arrivals *arrivals);

/* From a place to a particle of a store, m2: the square of the way through the nearest periodic
 * image. Local. */
double hc_arrivals_square(const hc_frame *frame, const hc_particles *particles, int32_t particle,
                          const int64_t x[3]);

/* The bricks around a place, kept for the next place, which is mostly in the same one. Zeroed: of none; as
 * long as cells stay as they are. */
typedef struct hc_vicinity {
  bool known, any; /* of `brick`; has it or any around it particles? */
  hc_brick brick;
  int32_t adjacent[HC_ADJACENT];
} hc_vicinity;

/* The cell of a place, and what is around its brick; false if that is nothing. Local. */
bool hc_vicinity_find(hc_vicinity *vicinity, const hc_cells *cells, const int64_t x[3], int *cell);

/* Is there a particle, own or ghost, closer to the place? The clearance must not exceed a cell's edge. Local.
 */
bool hc_arrivals_blocked(const hc_frame *frame, const hc_cells *cells, const hc_particles *particles,
                         hc_vicinity *vicinity, const int64_t x[3], double clearance);

#endif
