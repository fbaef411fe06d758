/* Walls that move as the scene prescribes: their poses, the same on every rank, and what they make of the
 * boundary particles.
 *
 * Rank 0 evaluates the motions and sends the poses, so that mixed machines agree. Positions and normals
 * follow from the reference that each particle keeps and the pose at a time, never from where the wall was
 * before: a restart, a rollback or a rebalance comes to the same bits.
 *
 * A wall stands at x(t) during the step from t on and moves with v(t). Boundary volumes are those of the
 * start, of each moving wall by itself (Akinci et al. 2012: a rigid body's own samples): walls
 * that come together or part keep them.
 *
 * Known weakness: while any wall moves, all boundary particles are sorted and get their ghosts anew in each
 * step, which takes 50 to 70 ns for each (one core, 100,000 of them). */
#ifndef HC_MOVERS_H
#define HC_MOVERS_H

#include "comm/comm.h"
#include "rigid/motion.h"
#include "space/neighbors.h"

typedef struct hc_mover {
  int wall;         /* its number in the scene */
  hc_motion motion; /* its rows stay the caller's */
  double reach;     /* m: the farthest sample from the motion's centre */
} hc_mover;

/* Zeroed: none. */
typedef struct hc_movers {
  hc_mover *walls; /* own copies, by number */
  hc_pose *poses;  /* of each */
  int count;
  bool posed;   /* the poses are those of `time` */
  double time;  /* s */
  bool moving;  /* has any a speed now? */
  double speed; /* m/s: the largest of any sample, now or as far ahead as was asked */
} hc_movers;

/* The largest speed of a wall at a time, or `ahead` later, m/s. Local. */
double hc_mover_speed(const hc_mover *wall, double time, double ahead);

/* Copies `count` moving walls, ascending by number. Freed with hc_movers_free. Local. */
void hc_movers_init(hc_movers *moving, const hc_mover *walls, int count);
void hc_movers_free(hc_movers *moving);

/* Poses of a time, and `speed` of it and of `ahead` later, s; `held`: as if they stood still. True, on every
 * rank, if a pose has changed. Collective, but local if these are the poses there are. */
bool hc_movers_pose(hc_movers *moving, hc_comm *comm, double time, double ahead, bool held);

/* Start of a run, before the first pose: normals as they are become the reference. Local. */
void hc_movers_start(hc_particles *boundary);

/* Puts own boundary particles of moving walls where the poses say: position and normal. Local. */
void hc_movers_place(const hc_movers *moving, const hc_frame *frame, hc_particles *boundary);

/* Gives all own boundary particles their velocity, in `motion`; 0 where nothing moves. Local. */
void hc_movers_drive(const hc_movers *moving, const hc_frame *frame, hc_particles *boundary);

/* Leaves in the list of boundary particles into themselves only neighbours that move alike: of the same
 * moving wall, or of walls that never move. The field `wall` must be known, of ghosts too. Local. */
void hc_movers_part(const hc_movers *moving, const hc_particles *boundary, hc_neighbors *list);

#endif
