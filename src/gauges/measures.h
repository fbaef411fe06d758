/* Single measures on the particles of one rank; gauges.c adds them up over the ranks. */
#ifndef HC_MEASURES_H
#define HC_MEASURES_H

#include "comm/comm.h"
#include "moving_mean.h"
#include "rigid/bodies.h"
#include "scene/scene.h"
#include "space/frame.h"
#include "sph/sweeps.h"

enum { HC_GAUGE_COLUMNS = 6 }; /* the most that one gauge averages */

/* One gauge at work. */
typedef struct hc_gauge_state {
  double integral[HC_GAUGE_COLUMNS]; /* of what is averaged, over the time since the last reading */
  hc_moving_mean moving;             /* in place of it, if the scene says over what time */
  double radius;                     /* pressure: of what counts around the point, m */
  double area;                       /* pressure on a wall: weighted area of the samples around, m2 */
  double at[3], direction[3]; /* the gauge's point, m, and its direction, of unit length, 0 if it has none:
                                 with its wall, where that has gone */
  int wall;                   /* the wall's number; -1: none */
  int first_sum;              /* of a step's sums */
  const hc_body *body;        /* body, mooring */
} hc_gauge_state;

typedef struct hc_gauges {
  const hc_scene *scene;   /* the caller's */
  const hc_frame *frame;   /* the caller's */
  const hc_movers *movers; /* the caller's */
  const hc_bodies *bodies; /* the caller's */
  hc_comm *comm;
  hc_gauge_state *state; /* one for each of scene->output.gauges */
  double mass;           /* kg, of a fluid particle */
  hc_sum *sums;          /* of the step: of this rank, then of all; those of a gauge behind each other */
  int sum_count;         /* of all gauges that are averaged */
  double elapsed;        /* s, since the last reading */
} hc_gauges;

/* A place in units of the frame. */
typedef struct hc_point {
  int64_t x[3];
} hc_point;

hc_point hc_measure_point(const hc_frame *frame, const double metres[3]);

/* Position of a particle relative to a point, in metres, through the nearest periodic image. */
void hc_measure_offset(const hc_frame *frame, const int64_t position[3], const hc_point *point,
                       double offset[3]);

/* Is a particle within the gauge's box, or a periodic image of it, which is then at x, m? True without a box.
 */
bool hc_measure_in_box(const hc_scene_gauge *gauge, const hc_frame *frame, const int64_t position[3],
                       double x[3]);

/* sum p W and sum W over the fluid around the gauge's point. */
void hc_measure_point_pressure(const hc_gauges *gauges, int number, const hc_particles *fluid,
                               hc_sum sums[2]);

/* The axis of a gauge, 0 to 2, and which way along it, 1 or -1; the axis is -1 without one. */
int hc_measure_axis(const hc_scene_gauge *gauge, int *sign);

/* Where the scene puts a gauge's point, m, and its direction, of unit length: that of its axis; of a height
 * without one against gravity, +z without gravity; else 0. */
void hc_measure_stand(const hc_scene *scene, const hc_scene_gauge *gauge, double at[3], double direction[3]);

/* Weighted area of the wall's samples around the gauge's point, m2, where the scene puts both; of the store
 * and of the one joined to it. */
void hc_measure_patch_area(const hc_gauges *gauges, int number, const hc_particles *boundary, hc_sum *sum);

/* Particles that crossed the gauge's rectangle or a periodic image of it in the step that has brought them
 * here, along its axis less against it. */
int64_t hc_measure_crossings(const hc_gauges *gauges, const hc_scene_gauge *gauge, const hc_particles *fluid,
                             double dt);

/* Adds what the step pushed walls with to the sums of all force and wall pressure gauges: force and moment,
 * or the force weighted around the point; a gauge's sums begin at its state's first_sum. */
void hc_measure_wall_push(const hc_gauges *gauges, const hc_sweep *sweep, double dt, hc_sum *sums);

#endif
