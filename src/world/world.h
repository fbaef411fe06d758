/* The world of a run as one rank holds it: particles, cells, halos and lists, and how they are kept current.
 */
#ifndef HC_WORLD_H
#define HC_WORLD_H

#include "base/stopwatch.h"
#include "boundary/boundary.h"
#include "domain/halo.h"
#include "rigid/movers.h"

typedef struct hc_world {
  hc_comm *comm;
  hc_frame frame;
  hc_domain domain;
  hc_particles fluid, boundary;
  hc_cells cells, boundary_cells;
  hc_halo halo, boundary_halo;
  hc_neighbor_search search;
  hc_neighbors list, walls; /* fluid -> fluid, fluid -> boundary */
  hc_neighbors wetted;      /* boundary -> fluid, where walls have a pressure of their own */
  hc_record *contacts;      /* see hc_collision; room for contact_room, and as many velocities of walls */
  size_t contact_room;
  hc_movers moving;
  bool walls_moved; /* boundary particles have other positions or velocities than their cells and ghosts */
  const hc_sweeps *sweeps;
  hc_sweep sweep;
  const hc_boundary_ops *boundary_ops;
  double volume_factor, contact_limit; /* see boundary.h; limit 0: no contact */
  double mass;                         /* kg, of a fluid particle */
  int64_t fluid_total, boundary_total;
  hc_division division; /* the last */
  int32_t listed;       /* own fluid particles that the lists are of; -1: none */
  hc_stopwatch watch;
} hc_world;

/* What a world is made of, besides its particles. */
typedef struct hc_world_settings {
  hc_frame frame;
  double rest_density, mass;           /* kg/m3, kg */
  double volume_factor, contact_limit; /* see boundary.h; limit 0: no contact */
  const hc_boundary_ops *boundary_ops;
  hc_isa isa; /* the same on every rank */
} hc_world_settings;

/* An empty world; the caller fills fluid and boundary, on any rank, then calls hc_world_distribute. Local. */
void hc_world_init(hc_world *world, hc_comm *comm, const hc_world_settings *settings);
void hc_world_free(hc_world *world);

/* First decomposition and totals, of a start or a restart. Afterwards particles are with their owners; call
 * hc_world_update. Collective. */
void hc_world_distribute(hc_world *world, hc_divider divider);

/* Start of a run: as hc_world_distribute, and the volumes that boundary particles keep from then on, from
 * where they are now. Collective. */
void hc_world_start(hc_world *world, hc_divider divider);

/* Puts moving walls where they are at a time, s (hc_movers_pose); the next hc_world_update brings all
 * else in line. Cells, ghosts and lists stay those of before. Does nothing if they are there already, or
 * nothing ever moves. Collective. */
void hc_world_pose_walls(hc_world *world, double time, double ahead, bool held);

/* A new decomposition: divides, moves all particles, boundary lists; `busy` as in hc_work. Call
 * hc_world_update afterwards. Collective. */
void hc_world_rebalance(hc_world *world, hc_divider divider, double busy);

/* After fluid particles or walls have moved: migrate, sort, ghosts, neighbour lists. Collective.
 * Afterwards place and velocity of own and ghost particles are current; 1/density is not known yet. */
void hc_world_update(hc_world *world);

/* Share of all boundary particles that lie in or next to a cell with fluid. Collective. */
double hc_world_active_boundary(hc_world *world);

#endif
