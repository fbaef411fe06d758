/* From a scene to its particles: a plan of all samplings, and the share of one rank.
 *
 * Every rank makes the same plan and generates its share of each source; only where walls that are surfaces
 * meet others do ranks ask each other, for none holds more than its share of a surface's samples. Where the
 * particles belong is not looked at: migration brings them to their owners. */
#ifndef HC_POPULATE_H
#define HC_POPULATE_H

#include "comm/comm.h"
#include "particles/particles.h"
#include "setup/source.h"

/* Everything that is to be generated; owned by the caller, freed with hc_setup_plan_free. */
typedef struct hc_setup_plan {
  hc_frame frame;
  hc_setup_source *fluid;    /* one for each block, then the air of those that rest states fill */
  hc_setup_source *boundary; /* one for each wall */
  int fluid_sources, air_sources, boundary_sources;
  int64_t fluid_count, air_count, boundary_count; /* particles in all, on all ranks together */
  uint64_t seed;                                  /* of the shifts below */
  int64_t disorder[3];                            /* largest shift of fluid off its lattice, in units */
} hc_setup_plan;

/* Makes the plan of a scene; generates nothing. Where walls meet, samples of later ones are left out, see
 * union.h. `frame` is that of the same scene. On failure the plan is
 * empty and needs no freeing. Errors (HC_BAD_INPUT): boxes turned inside out or thinner than nothing,
 * coordinates beyond 2^31 cells, directions and lengths of nothing, a block or wall that reaches around a
 * periodic axis and meets itself, more than 2^40 particles in one source, more than 2^20 sources of a kind.
 * Collective over `comm`; null: this process alone, which then holds all samples of surfaces. */
hc_status hc_setup_plan_make(hc_comm *comm, const hc_scene *scene, const hc_frame *frame, hc_setup_plan *plan,
                             hc_error *error);
void hc_setup_plan_free(hc_setup_plan *plan);

/* The range [first, last) of `count` things that falls to a rank. */
void hc_setup_share(int64_t count, int rank, int size, int64_t *first, int64_t *last);

/* Whether a rank can hold its share of the plan: HC_BAD_INPUT for more than HC_RECORDS_MOST particles of a
 * kind. Local. */
hc_status hc_setup_check_share(const hc_setup_plan *plan, int rank, int size, hc_error *error);

/* Replaces what the three stores hold (fluid, walls that stand still, walls that move) by the rank's share of
 * the plan: position (wrapped into the periods; fluid shifted off its lattice as the scene asks), id (kind,
 * source, index of the sample), velocity, and of walls the normals, of moving ones the reference, which is
 * the position but not wrapped; all other state is 0. Together the shares of all ranks are the same particles
 * for any number of ranks. Errors (HC_BAD_INPUT): more than HC_RECORDS_MOST particles of a kind on this rank;
 * the stores are then unchanged. `rank` and `size` are those of the plan's communicator; a plan of one
 * process can make the share of any. Local: agree on the status afterwards. */
hc_status hc_setup_generate(const hc_setup_plan *plan, int rank, int size, hc_particles *fluid,
                            hc_particles *boundary, hc_particles *moving, hc_error *error);

/* Adds a rank's share of one source of fluid, or of its air, to what a store holds. Local. */
void hc_setup_add(const hc_frame *frame, const hc_setup_source *source, int rank, int size,
                  hc_particles *fluid);

/* The velocity that a block prescribes at a position, m/s. Local. */
void hc_setup_velocity(const hc_frame *frame, const hc_setup_source *source, const int64_t position[3],
                       double velocity[3]);

/* Gives the own particles of `fluid` the velocities that their blocks prescribe at their positions. Local. */
void hc_setup_velocities(const hc_setup_plan *plan, hc_particles *fluid);

#endif
