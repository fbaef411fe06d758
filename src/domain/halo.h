/* The halo: copies (ghosts) of the particles in cells next to ours, and refreshes of their values.
 *
 * A cell is copied to every rank that owns one of the 26 cells around it; across a periodic border also to
 * ourselves, shifted by the period. Both sides follow from the cell -> rank rule and from which cells are
 * occupied, so partners need not be known beforehand. Within a rank's message cells stand in memory order and
 * particles by id, so a ghost cell is one range of the arrays like any other and its order is the canonical
 * one.
 *
 * Use, each step: hc_cells_bin; hc_halo_mark; hc_cells_order; hc_halo_build. Then refreshes. */
#ifndef HC_HALO_H
#define HC_HALO_H

#include "domain.h"

/* What a refresh carries. */
typedef enum hc_halo_field {
  HC_HALO_PLACE_SCALAR, /* place.scalar: a multiplier of the pressure solvers, a boundary volume */
  HC_HALO_PLACE,        /* place: predicted positions, within a support radius of the true ones; its scalar */
  HC_HALO_MOTION,       /* motion: velocity and 1/density */
  HC_HALO_FACING        /* facing: a boundary particle's normal */
} hc_halo_field;

/* A border cell and a partner that gets a copy of it. */
typedef struct hc_halo_cell {
  int32_t rank;
  int32_t slot;    /* brick * 64 + cell in the sorted store's cells */
  int8_t shift[3]; /* periods to add */
} hc_halo_cell;

typedef struct hc_halo {
  hc_domain *domain;
  hc_particles *particles;
  hc_halo_cell *cells; /* sorted by rank, then as found */
  int32_t cell_count;
  size_t cell_capacity;
  hc_message *send, *receive;        /* per partner; bytes of a refresh that is under way */
  int32_t *send_begin, *ghost_begin; /* send_count + 1 and receive_count + 1: first cell, first ghost */
  int send_count, receive_count;
  size_t capacity[4];
  char *send_buffer, *receive_buffer;
  size_t send_capacity, receive_capacity;
  const hc_cells *source;
  hc_exchange exchange;
  MPI_Request *requests;
  size_t requests_capacity;
  hc_halo_field field;
  bool pending;
} hc_halo;

void hc_halo_init(hc_halo *halo, hc_domain *domain, hc_particles *particles);
void hc_halo_free(hc_halo *halo);

/* Finds the border cells among the binned ones, sets their bits. Local. */
void hc_halo_mark(hc_halo *halo, hc_cells *cells);

/* Sends the places of border cells, enters the ghosts into the arrays (place with scalar 0) and the cells.
 * Collective. Before: marked and ordered. */
void hc_halo_build(hc_halo *halo, hc_cells *cells);

/* A refresh of one field of all ghosts: begin sends the border particles' values, which must be final, and
 * never waits; until end neither ghosts nor the field of border particles may be read or written. One at a
 * time. Collective among partners; both must be called by every rank. */
void hc_halo_begin(hc_halo *halo, hc_halo_field field);
void hc_halo_end(hc_halo *halo);

/* Begin and end in one. */
void hc_halo_refresh(hc_halo *halo, hc_halo_field field);

#endif
