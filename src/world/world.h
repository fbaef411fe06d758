/* The world of a run as one rank holds it: the stores of particles with their cells, halos and lists, and how
 * they are kept current. It knows no solver, and not what moves walls. */
#ifndef HC_WORLD_H
#define HC_WORLD_H

#include "base/stopwatch.h"
#include "boundary/boundary.h"
#include "domain/halo.h"

/* A set of particles on the map of bricks. */
typedef struct hc_store {
  hc_particles particles;
  hc_cells cells;
  hc_halo halo;
  hc_neighbors wetted; /* boundary -> fluid, where walls have a pressure of their own */
  bool moved;          /* its particles have other positions or velocities than its cells and ghosts */
} hc_store;

/* The stores of a world. Samples of walls that move are apart from those that stand still, which so cost
 * nothing while something moves; their records are joined (hc_particles_join), so that a particle has one
 * list of all walls. */
typedef enum hc_store_id { HC_STORE_FLUID, HC_STORE_BOUNDARY, HC_STORE_MOVING, HC_STORE_COUNT } hc_store_id;

/* Particles that are chosen for a part of a step: work space, kept for its memory. */
typedef struct hc_chosen {
  int32_t *index;    /* ascending */
  uint64_t *bits;    /* of own particles */
  uint64_t *ghosts;  /* of ghosts whose owner has chosen them */
  uint64_t *touched; /* of own particles and ghosts behind them: chosen, or next to those that are */
  float *asked;      /* of own particles and ghosts, or of own particles */
  double *before;    /* three for each chosen one */
  hc_record *placed; /* the fluid's places, ghosts too, when they were remembered */
  size_t placed_room, index_room, bits_room, ghosts_room, touched_room, asked_room, before_room;
} hc_chosen;

typedef struct hc_world {
  hc_comm *comm;
  hc_frame frame;
  hc_domain domain;
  hc_store stores[HC_STORE_COUNT];
  hc_particles *fluid, *boundary, *moving; /* of the stores, */
  hc_cells *cells;                         /* and the fluid's */
  hc_halo *halo;
  hc_neighbor_search search;
  hc_neighbors list, walls; /* fluid -> fluid, fluid -> boundary */
  hc_neighbors some;        /* fluid -> fluid, of chosen particles */
  hc_selection listed;      /* the fluid particles that the lists are of */
  hc_record *contacts;      /* see hc_collision; room for contact_room, and as many velocities of walls */
  size_t contact_room;
  hc_holds holds;
  hc_touches touches;
  double block;  /* s: of individual steps, the last; 0: there was none */
  double margin; /* m: by which lists reach farther than the support, at least */
  bool holding; /* fluid particles whose ids are of kind HC_ID_HELD stand still, also while a solver looks for
                   pressures */
  hc_chosen chosen;
  hc_wall_friction *friction; /* see hc_sweep; owned */
  const hc_sweeps *sweeps;
  hc_sweep sweep;
  const hc_boundary_ops *boundary_ops;
  double volume_factor, contact_limit; /* see boundary.h; limit 0: no contact */
  double start_limit;                  /* the most wall density that fluid may start with */
  double mass;                         /* kg, of a fluid particle */
  int64_t fluid_total, boundary_total;
  hc_division division; /* the last */
  hc_stopwatch watch;
} hc_world;

/* What a world is made of, besides its particles. */
typedef struct hc_world_settings {
  hc_frame frame;
  double rest_density, mass;           /* kg/m3, kg */
  double volume_factor, contact_limit; /* see boundary.h; limit 0: no contact */
  double start_limit;                  /* the most wall density that fluid may start with */
  double flat_wall;                    /* see hc_sweep; 0: wall densities are sums */
  hc_wall_friction *friction;          /* of each wall, from hc_alloc: the world frees it; null: none */
  bool friction_differs, no_slip, compressible; /* see hc_sweep */
  hc_wall_drag drag;
  const hc_boundary_ops *boundary_ops;
  unsigned features;  /* HC_FOR_*: of solver, boundary method and movers together */
  hc_isa isa;         /* the same on every rank */
  int ranks_per_host; /* see hc_hosts_find */
} hc_world_settings;

/* An empty world, which must stay where it is; the caller fills the stores' own particles, on any rank, then
 * calls hc_world_distribute. Collective. */
void hc_world_init(hc_world *world, hc_comm *comm, const hc_world_settings *settings);
void hc_world_free(hc_world *world);

/* First decomposition and totals, of a start or a restart. Afterwards all particles are with their owners,
 * boundary particles in their cells; call hc_world_update. Collective. */
void hc_world_distribute(hc_world *world, hc_divider divider);

/* Finds fluid_total, where particles have come or gone. Collective. */
void hc_world_count_fluid(hc_world *world);

/* Start of a run: as hc_world_distribute, and the volumes that boundary particles keep from then on, from
 * where they are now: of the walls that stand still together, of each moving wall by itself (Akinci et al.
 * 2012: a rigid body's own samples). Collective. */
void hc_world_start(hc_world *world, hc_divider divider);

/* A new decomposition: divides, moves all particles, boundary lists; `busy` as in hc_work. Call
 * hc_world_update afterwards. Collective. */
void hc_world_rebalance(hc_world *world, hc_divider divider, double busy);

/* Everything positional, after particles have moved: migration, cells, ghosts; of moving walls too, where
 * something has set `moved`. Afterwards place and motion of own fluid particles are current (1/density is not
 * known yet), of ghosts place. Collective. */
void hc_world_place(hc_world *world);

/* Lists made from now on reach `margin` m farther than the support, and no farther than the frame's. Local.
 */
void hc_world_reach(hc_world *world, double margin);

/* The neighbour lists of selected fluid particles (null: all), and ghosts' motion. Those of walls always
 * reach as far as the frame allows. Behind hc_world_place. Collective. */
void hc_world_list(hc_world *world, const hc_selection *selection);

/* Remembers where the fluid is shown, ghosts too; and lists the neighbours that selected particles (by an
 * index) had then, as far as the frame allows: sweeps see this list until they are shown that of all again,
 * rows at the particles' numbers, those of others empty. Local. */
void hc_world_remember_places(hc_world *world);
void hc_world_list_some(hc_world *world, hc_selection selection);
void hc_world_show_all(hc_world *world);

/* Both, of all particles. Collective. */
void hc_world_update(hc_world *world);

/* Own boundary particles that lie in or next to a cell with fluid. Local. */
int64_t hc_world_active_boundary(const hc_world *world);

#endif
