/* Gauges: what a run measures on its particles, exact across ranks.
 *
 * - height: depth of water along a line, against gravity or along an axis, the length that is wet; gaps of up
 *   to 1.5 spacings closed, a rough surface read at its mean (heights.h).
 * - front: farthest water along an axis, half a spacing beyond the last particle; nan where there is none.
 * - pressure: at a point in the fluid, the kernel's weighted mean of the particles around. With a wall: the
 *   push on the wall's samples around the point over their area, which is exact in the mean where the
 *   pressures of the layer next to a wall are not. With an axis too: only the samples of the face through the
 *   point count, and only the push along the axis, of fluid in front of it. The kernel ends at the gauge's
 *   radius, by default the support radius. Samples of inner edges are no area. Known weakness: half a
 *   spacing from an inner edge it reads a quarter low in still water, 8 % a spacing from it.
 *   Where the wall moves, point and face go with it, and so does the point of a force's moment.
 * - flow: volume per time through a rectangle, counted particle by particle.
 * - force: force of pressure, viscosity, contact and friction, and its moment, on a wall or body.
 * - energy: kinetic and potential.
 * - volume: sum of m/max(rho, rho0), what compression takes away.
 * - density: mean of the particles' densities; deep in the water it tells whether that has swollen. nan where
 *   there is none.
 * - body: where the centre of mass of a body is, how the body is turned since the start (roll, pitch, yaw
 *   about the scene's x, y and z, in this order, degrees), its velocity and angular velocity, and the fluid's
 *   force and torque about the centre of mass.
 * - mooring: the tension of a mooring.
 *
 * Boxes, rectangles and what is around a point are found through periodic images.
 *
 * Pressure, flow, forces and tensions are means over the time since the last reading, step by step, so that
 * no impulse falls between two readings, or, but for bodies, over the scene's mean_over, however often
 * they are read (moving_mean.h); the others are of the moment. All sums are exact, extremes need no order:
 * the same values on any number of ranks. The averages under way are state of the run. */
#ifndef HC_GAUGES_H
#define HC_GAUGES_H

#include "comm/tally.h"
#include "measures.h"

/* Sets up the scene's gauges; scene, frame, movers and bodies stay in use. Local. */
void hc_gauges_init(hc_gauges *gauges, hc_comm *comm, const hc_scene *scene, const hc_frame *frame,
                    const hc_movers *movers, const hc_bodies *bodies, double mass);
void hc_gauges_free(hc_gauges *gauges);

/* Registers the averages under way. Local. */
void hc_gauges_register(hc_gauges *gauges, hc_state *state);

/* Finds the samples of the walls that are measured, before the first step or reading. Boundary particles must
 * be with their owners. HC_BAD_INPUT, agreed, for a pressure on a wall that has no sample within its
 * radius of the point. Collective. */
hc_status hc_gauges_find_walls(hc_gauges *gauges, const hc_particles *boundary, hc_error *error);

/* Columns of all gauges together, and the name of one of them (such as "box_fx"). Local. */
int hc_gauges_columns(const hc_scene *scene);
void hc_gauges_column_name(const hc_scene *scene, int column, char *name, size_t size);

/* In each step, behind its move: notes in the tally what is averaged. `sweep` still has the places and wall
 * lists that the step worked with, positions are those after it, and movers stand where they stood as it
 * began. Local. */
void hc_gauges_note(hc_gauges *gauges, const hc_sweep *sweep, double dt, hc_tally *tally);

/* Once that is reduced, and the step counts: adds it to the averages. Local. */
void hc_gauges_step(hc_gauges *gauges, double dt);

/* The values of all columns, on every rank, and a new start for the averages since the last reading.
 * Collective: one reduction for all that is summed or a front, one gather for all heights. */
void hc_gauges_read(hc_gauges *gauges, const hc_particles *fluid, double *values);

#endif
