/* `halocline info FILE`: what a snapshot or checkpoint holds, for people or as one JSON object.
 *
 * A field's least, mean and largest value are those of the kinds that have the field; of a vector, of its
 * magnitude; NaNs are counted and left out of least and largest. Mass, momentum, kinetic and potential energy
 * are the fluid's: mass where the file tells that of a particle, momentum and kinetic energy where it holds
 * velocities too. The potential is that of gravity and 0 at the scene's origin, as in steps.csv. Sums are
 * exact, so that none of this depends on the ranks that wrote the file.
 *
 * The keys of the JSON object, null where a number is not known (or none): file, content ("snapshot" or
 * "checkpoint"), format, version, scene, time, step, dt, pieces, particles, fluid, boundary,
 * particle_spacing, support_radius, rest_density, gravity [3], particle_mass, mass, momentum [3],
 * kinetic_energy, potential_energy; extents: an object with fluid and boundary, each {low [3], high [3]} of
 * the particles' positions in m, or null where there are none; fields: a list of {name, type, components,
 * unit, kinds ["fluid", "boundary"], min, mean, max, not_numbers}. */
#ifndef HC_INFO_H
#define HC_INFO_H

#include "halocline/error.h"

#include <stdbool.h>
#include <stdio.h>

/* Describes the file on `out`. Local. HC_BAD_INPUT if it cannot be read (nothing is printed then),
 * HC_IO_FAILED if `out` cannot be written. */
hc_status hc_info_print(const char *path, bool json, FILE *out, hc_error *error);

#endif
