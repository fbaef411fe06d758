/* What walls do to the fluid next to them besides pushing it with a mirrored pressure: friction, and what the
 * pressure behind the wetted surface gains by depth. Both are explicit changes of velocity before the
 * pressure solve, and both act on the walls' samples in turn (wall_force.h).
 *
 * Friction of a wall (none, no slip, smooth, rough), after Werner and Wengle 1993 and the logarithmic law of
 * rough walls: the shear stress follows from the velocity u along the wall, relative to it, at a distance y,
 * tau/rho0 = r u, with
 *   r = nu/y                           where u y/nu <= 139.5, or without slip
 *   r = 0.0246385 u/(u y/nu)^(1/4)     beyond
 *   r = (0.41/ln(30 y/k_s))^2 u        over rough walls, where that is more
 * and a particle stands for a volume with the wall area a per volume in it, so that u <- u/(1 + dt a r): it
 * never turns u round, and depends on neither spacing nor step. With sums over the samples in front of which
 * a particle is, weighed by W, y is the mean height over them less half a spacing, and a = 2 V |sum grad W|,
 * 1/spacing at one spacing.
 *
 * Depth: a mirrored pressure has no gradient along the wall. The pressure at sample b is taken to be
 * p_i + rho0 g.(x_b - x_i), as it is in fluid at rest (Adami, Hu, Adams 2012); the difference pushes by
 * dv_i = -dt s_i sum V_b (g.(x_b - x_i)) grad W. s_i = p_i/(rho0 |g| spacing), at most 1: fluid without
 * pressure is not held to walls. */
#ifndef HC_WALL_LAYER_H
#define HC_WALL_LAYER_H

#include "solver.h"

/* As a step begins: lists the particles next to walls, if any have friction or depth acts. Local. Behind
 * hc_world_list. */
void hc_wall_layer_list(hc_world *world, bool depth);

/* The same with what acts by depth. `pressure`: of the step before, Pa, by particle, with its accelerations;
 * null: no depth. Local. */
void hc_wall_layer_look(hc_world *world, const hc_solver_settings *settings, const float *pressure);

/* Acts on those of own fluid particles [begin, end), motion too. Local. */
void hc_wall_layer_act(hc_world *world, const hc_solver_settings *settings, double dt, int32_t begin,
                       int32_t end);

/* For solvers that know no step yet: adds what walls do to selected particles over dt to `change`, m/s, three
 * a particle, with the depth of their present pressures; and says that it was but a share of that dt. Local.
 */
void hc_wall_layer_add(hc_world *world, const hc_solver_settings *settings, double dt, float *change,
                       hc_selection selection);
void hc_wall_layer_shorten(hc_world *world, double share);

/* How much of what a particle lost by friction sample b takes, of all the samples it is near: W where the
 * particle is in front of a wall with friction, else 0. `d`: from sample to particle, in support radii. */
double hc_wall_layer_share(const hc_sweep *sweep, const double d[3], int32_t b);

#endif
