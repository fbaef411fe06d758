/* Partners: the ranks that a store's particles may have to do with in a step, so that its exchanges need no
 * barrier.
 *
 * In reach of a rank are the bricks that its particles occupy and those around them. All who own a cell of or
 * beside a brick in somebody's reach, and that rank, are partners of each other: a particle that moves into
 * the brick may go from any of them to any other, and have ghosts with a third. This is learnt by one sparse
 * exchange, which carries the bricks, and holds as long as no particle leaves what is covered. Whether one
 * does is found when particles have moved and agreed among all ranks; then the next exchanges are sparse
 * ones, and partners are learnt anew. */
#ifndef HC_PARTNERS_H
#define HC_PARTNERS_H

#include "comm/comm.h"
#include "map.h"
#include "particles/particles.h"

/* What partners follow from; the caller's. */
typedef struct hc_partners_of {
  hc_comm *comm;
  const hc_frame *frame;
  const hc_map *map;
} hc_partners_of;

typedef struct hc_partners {
  const hc_particles *particles; /* whose they are; null: nobody's */
  bool known;                    /* learnt, and no particle has left what is covered; same on every rank */
  bool agreed;                   /* for the particles as they lie now, too */
  int32_t *ranks;                /* ascending, without this one */
  int32_t count;
  size_t room;
  hc_brick_set covered; /* bricks of or beside other ranks' cells, and those found to be all ours since */
} hc_partners;

void hc_partners_init(hc_partners *partners);
void hc_partners_free(hc_partners *partners);

/* Learns the partners of particles that are with their owners. Collective: one sparse exchange. */
void hc_partners_learn(hc_partners *partners, const hc_partners_of *of, const hc_particles *particles);

/* Do all own particles, which need not be with their owners, lie in what is covered? Local. */
bool hc_partners_cover(hc_partners *partners, const hc_partners_of *of);

#endif
