/* Boundary samples of a surface, close to evenly spread at the particle spacing.
 *
 * Method: the samples lie on the surface moved to the wall's side, by half a spacing for the first layer and
 * by 1.5 spacings for the second. A vertex moves to where all faces around it come to lie so far behind (the
 * least squares of that, by at most twice as far), so that edges and corners stay sharp. First corners and
 * creases are sampled, at equal arcs of about a spacing. Then the faces: candidates much denser than the
 * spacing, from which one after the other in an order shuffled by a fixed rule is taken that keeps a distance
 * from all before; the result is evened out by some rounds of Lloyd's algorithm (each sample moves to the
 * candidate nearest to the mean of the candidates that are nearest to it); at last samples that are still
 * crowded go and holes are filled, the largest first. Everything goes by index: the result depends on the
 * mesh alone.
 *
 * Walls thinner than 1.5 spacings have one layer in their middle, without a normal, walls up to about 3 one
 * layer a side: candidates that come too close to the surface elsewhere are left out.
 *
 * Among ranks the work is divided by setup/divide.h. */
#ifndef HC_SURFACE_SAMPLES_H
#define HC_SURFACE_SAMPLES_H

#include "surface_layer.h"

/* Fills surface->samples, the first layer before the second. `fluid_inside`: the fluid is within a closed
 * surface; else on the side that its triangles look at. A surface so small that nothing fits behind it has
 * one sample in its middle. HC_BAD_INPUT: more than 2^24 candidates would be needed, some 600,000 samples.
 * Local. */
hc_status hc_surface_samples_make(hc_surface *surface, double spacing, int layers, bool fluid_inside,
                                  hc_error *error);

/* The steps of this, for those who divide the work: check a layer, make the candidates of all its places, in
 * parts as they like, and choose samples among them, in the order of the places, which are appended to
 * surface->samples; those of the layers before must be there. */
hc_status hc_surface_samples_check(const hc_surface_layer *layer, hc_error *error);
void hc_surface_samples_choose(hc_surface *surface, const hc_surface_layer *layer,
                               hc_sample_candidates *candidates);

#endif
