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
 * The parts share out the places at which candidates may be; see sample_choice.h for how they choose. */
#ifndef HC_SURFACE_SAMPLES_H
#define HC_SURFACE_SAMPLES_H

#include "surface_layer.h"

/* Fills surface->samples, the first layer before the second, with our share of them. `fluid_inside`: the
 * fluid is within a closed surface; else on the side that its triangles look at. A surface so small that
 * nothing fits behind it has one sample in its middle. HC_BAD_INPUT, for all parts: more than 2^25 candidates
 * would be needed, about a million samples. Collective over `parts`; the samples are the same to the bit for
 * any number of them. */
hc_status hc_surface_samples_make(hc_surface *surface, double spacing, int layers, bool fluid_inside,
                                  const hc_parts *parts, hc_error *error);

#endif
