/* Contact of bodies with walls and with each other.
 *
 * Samples touch samples: both lie half a spacing behind their surfaces, so that surfaces meet where a sample
 * is a spacing in front of the plane of the other's (or, where that is an edge without a face, a spacing away
 * from it). Thousands of samples that touch are told by few: of those that a body has in contact with another
 * thing, on a side of it, the farthest along each of 26 directions and the deepest (ties: the lowest id), so
 * that the corners of a patch stand for it. The choice is the same however the samples are spread over the
 * ranks. Then every rank solves the same contacts, one after the other, again and again (sequential impulses,
 * Catto 2005): a point may come as near as it has room for within the step, so that nothing tunnels; what is
 * too deep is let out slowly; dry friction as far as the normal impulse bears it; restitution of what comes
 * in fast. */
#ifndef HC_CONTACT_H
#define HC_CONTACT_H

#include "bodies.h"

/* Changes the momenta of bodies so that over dt none goes into a wall or another. Collective: one gather.
 * Before: the world is placed as the bodies stand, and hc_bodies_touch. */
void hc_contact_resolve(hc_bodies *bodies, hc_world *world, double dt);

#endif
