/* What moves boundary samples: walls that go as the scene prescribes, and bodies (bodies.h).
 *
 * Poses are the same on every rank: rank 0 evaluates the motions and sends them, so that mixed machines
 * agree. Positions and normals follow from the reference that each sample keeps and the pose at a time, never
 * from where it was before: a restart, a rollback or a rebalance comes to the same bits.
 *
 * A wall stands at x(t) during the step from t on and moves with v(t). Boundary volumes are those of the
 * start, of each moving wall by itself (hc_world_start): walls that come together or part keep them. */
#ifndef HC_MOVERS_H
#define HC_MOVERS_H

#include "motion.h"
#include "world/world.h"

typedef struct hc_mover {
  int wall;         /* its number among walls and bodies */
  hc_motion motion; /* its rows are the movers' */
  double reach;     /* m: the farthest sample from the motion's centre */
  hc_pose given;    /* HC_MOTION_BODY: its pose, by whoever moves it */
} hc_mover;

/* Zeroed: none. */
typedef struct hc_movers {
  hc_mover *walls;     /* by number */
  hc_motion_row *rows; /* of their tables */
  hc_pose *poses;      /* of each */
  int count;
  bool posed;   /* the poses are those of `time` */
  double time;  /* s */
  double speed; /* m/s: the largest of any sample, now or as far ahead as was asked */
} hc_movers;

/* The largest speed of a wall at a time, or `ahead` later, m/s. Local. */
double hc_mover_speed(const hc_mover *wall, double time, double ahead);

/* Makes room for `count` walls, zeroed, and `rows` rows of tables; the caller fills them, ascending by
 * number. Freed with hc_movers_free. Local. */
void hc_movers_init(hc_movers *movers, int count, int rows);
void hc_movers_free(hc_movers *movers);

/* Start of a run, before the first pose: normals of moving samples as they are become the reference. Local.
 */
void hc_movers_start(hc_particles *moving);

/* Puts own moving samples where the poses say: position, normal, velocity. Local. */
void hc_movers_place(const hc_movers *movers, const hc_frame *frame, hc_particles *moving);

/* Where a point that the scene puts on a wall has gone with it, m, and how a direction has turned, by the
 * poses there are; `ahead`, s, later at the velocity that it has. Both stay if the wall stands still. Local.
 */
void hc_movers_carry(const hc_movers *movers, const hc_frame *frame, int wall, double ahead, double x[3],
                     double direction[3]);

/* Finds the poses of a time, s, and places the world's moving samples by them; `held`: as if they stood
 * still. `speed` is then that of the time and of `ahead` later. The next hc_world_place brings cells and
 * ghosts in line. Does nothing if these are the poses there are. Collective. */
void hc_movers_pose(hc_movers *movers, hc_world *world, double time, double ahead, bool held);

#endif
