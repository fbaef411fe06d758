/* Prescribed motions: where a rigid thing stands at a time, and how it moves, as a closed form of the time.
 *
 * A pose turns the thing about the motion's centre and then shifts it; pose zero leaves it where the scene
 * puts it. Poses are never added up, so that any time can be gone to, from anywhere, to the same bits. Sines
 * and cosines are those of base/turns.h. All functions are local. */
#ifndef HC_MOTION_H
#define HC_MOTION_H

#include <stdbool.h>
#include <stdint.h>

typedef enum hc_motion_law {
  HC_MOTION_STILL,
  HC_MOTION_CONSTANT, /* shift and turns grow with the time since the start */
  HC_MOTION_COSINE,   /* shift and turns times cos(2 pi (f t + phase)) - cos(2 pi phase) */
  HC_MOTION_BODY,     /* as a rigid body goes (bodies.h): its poses are not made here */
  HC_MOTION_TABLE     /* between the rows of a table, before the first and behind the last as there */
} hc_motion_law;

/* A row of a table: time since the start, s, and the pose, m and whole turns. */
typedef struct hc_motion_row {
  double time, shift[3], turns;
} hc_motion_row;

typedef struct hc_motion {
  hc_motion_law law;
  double start, stop;        /* s: before it stands at its first pose, afterwards at the one it has come to */
  double centre[3];          /* m: of the turn */
  double axis[3];            /* of the turn, of unit length */
  double shift[3], turns;    /* constant: m/s, 1/s; cosine: amplitudes, m and whole turns */
  double frequency, phase;   /* cosine: Hz, whole turns */
  bool smooth;               /* table: with a continuous velocity, else straight from row to row */
  const hc_motion_row *rows; /* table: times ascending; the caller's */
  int row_count;
} hc_motion;

/* Where it stands and how it moves. A point that pose zero has at X is at X + shift + turn (X - centre). */
typedef struct hc_pose {
  int64_t
      units[3];    /* of the frame, beside the shift: of bodies, whose places are exact however far they go */
  double shift[3]; /* m */
  double turn[3][3];  /* the rotation less the identity: exactly 0 without a turn */
  double velocity[3]; /* m/s, of what was at the centre */
  double spin[3];     /* rad/s, about it */
} hc_pose;

/* At a time, s. The velocity is the derivative of the pose from this time on. */
hc_pose hc_motion_pose(const hc_motion *motion, double time);

/* The largest speed of what lies within `reach` (m) of the centre, m/s. */
double hc_pose_speed(const hc_pose *pose, double reach);

/* Does it ever turn? And the smallest box that holds all shifts up to a time (a smooth table may go a little
 * beyond its rows), m. */
bool hc_motion_turns(const hc_motion *motion);
void hc_motion_range(const hc_motion *motion, double until, double low[3], double high[3]);

#endif
