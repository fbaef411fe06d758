/* Samplings of surfaces: see surface_samples.h for walls. Local; positions rounded to units. */
#ifndef HC_SURFACE_SAMPLING_H
#define HC_SURFACE_SAMPLING_H

#include "sampling.h"
#include "surface.h"

/* A closed surface as a shape, or an open one: what is in front of that counts as inside. The shape refers to
 * the surface. */
hc_shape hc_surface_sampling_shape(const hc_surface *surface);

/* The samples of a surface; the sampling refers to those that are held here. */
hc_sampling hc_surface_sampling_wall(const hc_lattice *lattice, const hc_surface *surface);

/* The fluid lattice in a closed surface: as hc_sampling_block of the box around it, without the points closer
 * than half a spacing to the surface. Its rows are stored, from one end to the other in a stretch. */
hc_sampling hc_surface_sampling_fill(const hc_lattice *lattice, const hc_surface *surface);

#endif
