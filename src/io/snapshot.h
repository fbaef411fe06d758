/* Snapshots: one VTKHDF 1.0 file per moment, written by all ranks together; ParaView 5.11 opens it as it is.
 *
 * /VTKHDF is an UnstructuredGrid with one vertex cell per particle and one piece per rank; within a piece the
 * own fluid particles come first, then the own boundary particles, those of moving walls last, in the order
 * of the stores. Points float64 [N,3], scene coordinates in metres PointData/id        int64: the bits of the
 * unsigned id PointData/kind uint8: 0 fluid, 1 boundary (hc_id_kind) PointData/<field>   the requested rows
 * of fields.def; zeros for a kind that lacks the field /Halocline, which ParaView ignores, holds what our own
 * tools read: attributes format_version, program_version, scene, time [s], step, dt [s], particle_spacing
 * [m], support_radius [m], rest_density [kg/m3], particle_mass [kg, of a fluid particle], gravity [m/s2],
 * unit [m], origin, period, low [units], fluid_particles, boundary_particles; in /Halocline/units the unit of
 * each field, in /Halocline/kinds the kinds that have it (HC_FLUID | HC_BOUNDARY), by attributes of its name;
 * and /Halocline/fluid_per_piece, int64 [pieces].
 *
 * The integer position relative to the scene's origin is llrint(Points / unit), exactly, below 2^48 units.
 * The bytes of a file depend on the state and the number of ranks only. */
#ifndef HC_SNAPSHOT_H
#define HC_SNAPSHOT_H

#include "comm/comm.h"
#include "halocline/error.h"
#include "scene/scene.h"
#include "state/moment.h"

/* Writes DIRECTORY/snapshots/snap_NNNNNN.hdf (NNNNNN = number) and the new snapshots/run.hdf.series.
 * Of the scene: name, spacing, gravity, rest density, requested fields.
 * Collective; every rank returns the same. Transient memory: about 20 MiB, whatever the number of particles.
 * On failure nothing appears under the final name and the temporary is removed; only if run.hdf.series cannot
 * be written is the snapshot there without an entry in it.
 * HC_IO_FAILED: the disk is full, the directory not writable. HC_BAD_INPUT: a requested field does not exist.
 */
hc_status hc_snapshot_write(hc_comm *comm, const hc_scene *scene, const hc_moment *moment,
                            const char *directory, int number, hc_error *error);

/* The same of the moment in which a run failed: DIRECTORY/snapshots/fault_NNNNNN.hdf (NNNNNN = the moment's
 * step). It is no part of run.hdf.series, whose scales one broken particle would spoil. */
hc_status hc_snapshot_write_fault(hc_comm *comm, const hc_scene *scene, const hc_moment *moment,
                                  const char *directory, hc_error *error);

/* About how large the snapshot of so many particles is, of both kinds together: right to some KiB, packed
 * columns taken for 0.15 bytes a particle. Local. HC_BAD_INPUT as above. */
hc_status hc_snapshot_bytes(const hc_scene *scene, int64_t particles, int64_t *bytes, hc_error *error);

#endif
