/* Particles with time steps of their own in a weakly compressible fluid: He, Ban, Liu, Wang 2015, section 2.3
 * and algorithm 2.
 *
 * A step of the run is a block of sub-steps, of one or several of the longest steps. At its beginning all
 * particles are active; then each when its own step is over: only active ones find their density, their
 * forces and how long their next step is; the others go on as they were last found, v = v_last + t a, x =
 * x_last + t v, with densities that follow dD/dt (lines 8, 9, 18 to 21). A particle's step is the least of
 * its own raw step and those of its neighbours (line 16); a neighbour that is not active is woken in time by
 * one whose raw step is shorter. At a block's end all are at one time again.
 *
 * Times in a block are ticks, 2^-20 of it, so that they are exact. Steps are powers of two of it, due at
 * multiples of themselves, or the raw steps of the paper: then the next sub-step is as long as the shortest
 * step.
 *
 * Beyond the paper: blocks; in raw steps too no particle steps across one, and its step is no longer than
 * sound is stable with. Where a neighbour's raw step has grown, line 16 would let an inactive particle's grow
 * at once; here it does when that particle is active. Walls that move go on in a block as they are at its
 * beginning.
 *
 * Cells are wider than the support by a margin. In a block of several of the longest steps lists are of all
 * particles and reach as far as the block needs; in one of a single longest step, as in fast water, hardly
 * anybody is active but at its beginning: there lists of all reach no margin, and who is active later gets
 * one of its own, from where all were when they were placed. They hold until what particles may have moved
 * has used up half of the margin; then (or, without `lasting`, in every sub-step) particles are placed and
 * listed anew at their positions of that time, which nobody's activation hangs on.
 *
 * What a sub-step costs follows who is active: of the others those next to them are looked at (block.h), and
 * messages carry rows of active particles: their pressures, what they go on from when they were active, and,
 * back to the owners, what raw steps ask of those beside them. */
#ifndef HC_INDIVIDUAL_H
#define HC_INDIVIDUAL_H

#include "block.h"

/* How far lists must reach beyond the support for a block of dt, m, by the largest speed and acceleration
 * before it: pairs may come nearer from both sides. */
double hc_individual_reach(const hc_weak_settings *settings, const hc_individual_settings *individual,
                           double speed, double force, double dt);

/* Moves all particles by a block of dt. As hc_solver_ops.step. Before: placed, listed, accelerations and
 * pressures of all found, with dD/dt in fluid->drift. Collective. */
hc_status hc_individual_advance(hc_world *world, const hc_weak_settings *settings,
                                const hc_individual_settings *individual, double dt, hc_step_report *report,
                                hc_error *error);

#endif
