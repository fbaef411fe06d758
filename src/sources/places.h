/* Places where fluid particles were at the start, kept for those that come later. They are at the owners of
 * their cells and go along with a window (simulation/displace.h), by whole units. */
#ifndef HC_PLACES_H
#define HC_PLACES_H

#include "arrivals.h"
#include "domain/domain.h"

/* A number for each sample of the blocks at the start, whether or not it was left out: for the ids of what
 * takes their places later. */
typedef struct hc_sample_numbers {
  int64_t *first; /* by block; owned */
  int64_t count;  /* of all, 1 at least */
} hc_sample_numbers;

/* Of a particle of the start. Local. */
int64_t hc_sample_number(const hc_sample_numbers *numbers, uint64_t id);

typedef struct hc_places {
  hc_particles store; /* positions, and ids that the owner of the places gives a meaning */
  int64_t shift[3];   /* units: by how much they have gone along */
  bool moved;         /* they may be elsewhere than with the owners of their cells */
  int64_t divisions;  /* of the domain, when they were settled */
} hc_places;

/* None; `kind` is one of HC_PLACES. Freed with hc_places_free. Local. */
void hc_places_init(hc_places *places, unsigned kind);
void hc_places_free(hc_places *places);

/* Adds some, wherever they are. Local. */
void hc_places_add(hc_places *places, const hc_arrivals *added);

/* Moves own particles of a store by whole units. Local. */
void hc_places_translate(hc_particles *store, const hc_frame *frame, const int64_t by[3]);

/* Brings them from where they have gone to so far to `shift`, units. Local, on all ranks. */
void hc_places_go(hc_places *places, const hc_frame *frame, const int64_t shift[3]);

/* Sends them to their owners, if the world has been divided anew or they have moved. Collective. */
void hc_places_settle(hc_places *places, hc_domain *domain);

#endif
