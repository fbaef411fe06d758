/* Rigid bodies: what moves as the fluid, gravity, moorings and contacts push it.
 *
 * A body is a mover (movers.h) whose pose is its own state: the place of its centre of mass in units, so that
 * a body a million cells away has the same bits; its turn as a quaternion; velocity and angular momentum in
 * double precision. Every rank holds every body and moves it alike, from the same sums, with + - * / and
 * square roots only.
 *
 * A step kicks and drifts: v += dt F/m, L += dt T, then x += dt v, and the turn goes on by the implicit
 * midpoint rule with L as it is then, to which it is symmetric: a top keeps its energy to second order,
 * without drift, and its angular momentum exactly. What is locked has no velocity along that axis of the
 * scene, whatever pushes: its mass there is infinite.
 *
 * Fluid that is nearly incompressible answers a body at once, so its solver must know how the body yields
 * while it looks for pressures (solver/yield.h): `shown` is the velocity that the solver works with, a
 * prediction. All functions but hc_bodies_touch are local. */
#ifndef HC_BODIES_H
#define HC_BODIES_H

#include "movers.h"
#include "state/state.h"
#include "touching.h"

/* A force on a body. */
typedef struct hc_pull {
  double force[3]; /* N; where it turns with the body, along the axes of the reference */
  double arm[3];   /* m: from the centre to where it pulls, in the reference */
  bool turns;
  double start, stop; /* s */
} hc_pull;

typedef struct hc_mooring {
  double arm[3], anchor[3];          /* m: as of a pull; the fixed end, in the scene */
  double length, stiffness, damping; /* m, N/m, N s/m */
  bool pushes;                       /* when it is shorter, too */
} hc_mooring;

/* Linear, and about the centre of mass: a velocity (m/s, rad/s), an impulse (N s, N m s), a force (N, N m).
 */
typedef struct hc_twist {
  double linear[3], angular[3];
} hc_twist;

typedef struct hc_body {
  int wall;                   /* its surface's number among walls and bodies */
  double mass, inertia[3][3]; /* kg, kg m2: about the centre, in the reference */
  double centre[3];           /* m: the centre of mass in the reference, */
  double reach;               /* m: the farthest sample from it, a spacing at least */
  unsigned locked;            /* bits 0 to 2: moves, 3 to 5: turns */
  double friction, restitution;
  hc_pull *pulls;
  hc_mooring *moorings;
  int pull_count, mooring_count;

  int64_t position[3]; /* state: of the centre of mass, units; not wrapped */
  double turn[4];      /* state: quaternion, real part first */
  double velocity[3];  /* state: m/s, of the centre of mass */
  double momentum[3];  /* state: kg m2/s, about it; 0 where turns are locked */
  double held[6]; /* state: force and torque that the last step found beside what the solver reckoned with: of
                     contacts that bear, friction; the next expects them */
  double load[6]; /* state: force and torque of the fluid in the last step, N, N m */

  double compliance[3][3]; /* 1/(kg m2): spin by angular momentum, as it stands */
  hc_twist shown;          /* the velocity that the solver works with, */
  hc_twist pushed;         /* and the impulses that it got in this step */
} hc_body;

/* Zeroed: none. */
typedef struct hc_bodies {
  hc_body *body;
  int count;
  int first;                                /* the number of the first one's surface */
  double gravity[3], pole[3], central_rate; /* as the fluid feels, see hc_solver_settings */
  double time;                              /* s: of the poses */
  hc_touching touching;                     /* as the world is placed */
  bool reckons;                             /* the solver reckons with how bodies yield */
  const hc_frame *frame;                    /* the caller's */
} hc_bodies;

/* Room for `count` bodies, zeroed; the caller fills them, with pulls and moorings from hc_alloc. */
void hc_bodies_init(hc_bodies *bodies, int count, const hc_frame *frame);
void hc_bodies_free(hc_bodies *bodies);

/* Behind hc_world_place: what touches counts once. Collective. */
void hc_bodies_touch(hc_bodies *bodies, hc_world *world);

/* Registers what is state. */
void hc_bodies_register(hc_bodies *bodies, hc_state *state);

/* The body whose surface has that number, or null. */
hc_body *hc_bodies_of(const hc_bodies *bodies, int wall);

/* At a time, bodies stand where their state says: makes poses of the movers of their surfaces, and shows the
 * velocities that they have. */
void hc_bodies_pose(hc_bodies *bodies, double time, hc_movers *movers);

/* Gravity, pulls and moorings, N and N m, as the body stands and moves. */
hc_twist hc_body_pull(const hc_bodies *bodies, const hc_body *body);

/* The tension of one of its moorings, N. */
double hc_body_tension(const hc_bodies *bodies, const hc_body *body, int mooring);

/* Changes what the solver works with by an impulse. */
void hc_body_push_shown(hc_body *body, const hc_twist *impulse);

/* Changes the body's own velocity by an impulse. */
void hc_body_push(hc_body *body, const hc_twist *impulse);

/* Behind a step in which the solver reckoned with the body: what really came in beyond that is what the next
 * step expects; of contacts what bears, not what has stopped it or thrown it back. `before`: its momentum as
 * the step began; `pushed`: before contacts. */
void hc_body_expect(const hc_bodies *bodies, hc_body *body, const hc_twist *before, const hc_twist *pushed,
                    double dt);

/* Its momentum, and that about its centre of mass. */
hc_twist hc_body_momentum(const hc_body *body);

/* Moves it on by its velocity over dt; false if that is no number or beyond all places. */
bool hc_body_drift(const hc_bodies *bodies, hc_body *body, double dt);

/* Its spin, rad/s, by its angular momentum; and a point of the reference, m from the centre, as the body
 * stands. */
void hc_body_spin(const hc_body *body, double spin[3]);
void hc_body_turned(const hc_body *body, const double arm[3], double turned[3]);

/* From the centre of mass to a position of the frame, through the nearest periodic image, m. */
void hc_body_arm(const hc_bodies *bodies, const hc_body *body, const int64_t position[3], double arm[3]);

/* The velocity at an arm, m/s. */
void hc_twist_at(const hc_twist *twist, const double arm[3], double velocity[3]);

/* The impulse of a linear one at an arm, added. */
void hc_twist_add_at(hc_twist *twist, const double arm[3], const double impulse[3]);

/* Roll, pitch and yaw about the scene's x, y and z, one behind the other, degrees. */
void hc_body_angles(const hc_body *body, double angles[3]);

/* Gives the samples of bodies the velocities shown, as sweeps read them: own ones. */
void hc_bodies_drive(const hc_bodies *bodies, hc_particles *moving);

#endif
