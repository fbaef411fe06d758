/* The halo: copies (ghosts) of the particles in cells next to ours, and refreshes of their values.
 *
 * A cell is copied to every rank that owns one of the 26 cells around it; across a periodic border also to
 * ourselves, shifted by the period. Both sides follow from the cell -> rank rule and from which cells are
 * occupied, so partners need not be known beforehand. Within a rank's message cells stand in memory order and
 * particles by id, so a ghost cell is one range of the arrays like any other and its order is the canonical
 * one.
 *
 * Use, each step: hc_cells_bin; hc_halo_mark; hc_cells_order; hc_halo_build. Then refreshes, of any rows of
 * fields.def that ghosts have, by name and several in one message, of all particles or of a selection; and
 * folds, which go the other way: what ghosts have gathered in some array comes back to the owner. Each halo
 * has a tag of its own, so that two may be under way at once. While a field is, the store says so (under_way)
 * and sweeps refuse to read it. */
#ifndef HC_HALO_H
#define HC_HALO_H

#include "domain.h"

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
  int32_t *copies; /* send_count: of our particles with each partner */
  size_t capacity[5];
  char *send_buffer, *receive_buffer;
  size_t send_capacity, receive_capacity;
  const hc_cells *source;
  hc_exchange exchange;
  MPI_Request *requests;
  size_t requests_capacity;
  int tag;
  hc_field_set fields;    /* under way; 0: none */
  const uint64_t *chosen; /* of own particles, while a refresh of a selection is under way; null: all */
} hc_halo;

/* `tag`: 0, 1, ..., another for each halo of a domain. */
void hc_halo_init(hc_halo *halo, hc_domain *domain, hc_particles *particles, int tag);
void hc_halo_free(hc_halo *halo);

/* Finds the border cells among the binned ones, sets their bits. Local. */
void hc_halo_mark(hc_halo *halo, hc_cells *cells);

/* Sends the places of border cells, enters the ghosts into the arrays (place with scalar 0) and the cells.
 * Collective. Before: marked and ordered. */
void hc_halo_build(hc_halo *halo, hc_cells *cells);

/* A refresh of some fields of all ghosts (HC_WHOLE(motion) | HC_SCALAR(place)): begin sends the border
 * particles' values, which must be final, and never waits; until end neither ghosts nor these fields of
 * border particles may be read or written. One at a time. Places are moved by the periods on their way.
 * Collective among partners; both must be called by every rank. */
void hc_halo_begin(hc_halo *halo, hc_field_set fields);
void hc_halo_end(hc_halo *halo);

/* Begin and end in one. */
void hc_halo_refresh(hc_halo *halo, hc_field_set fields);

/* The same for the own particles whose bit is set in `chosen` (bit k % 64 of word k / 64, room for all own
 * particles; it must stay until the end): a message is a bitmap and the rows it names, ghosts of others keep
 * their values. `selected`, one bit for each ghost, receives which were refreshed; may be null. */
void hc_halo_begin_some(hc_halo *halo, hc_field_set fields, const uint64_t *chosen);
void hc_halo_end_some(hc_halo *halo, uint64_t *selected);

/* Takes ghosts' values back to their owners: each own particle gets the least of its own and those of its
 * copies, component by component, which is the same in any order. `values` has `components` plain numbers (no
 * records) for each own particle and each ghost; only those of ghosts whose bit is set in `chosen` (as above,
 * ghosts behind own particles) go back. Ghosts keep theirs; refresh them if they must know. Collective among
 * partners. */
void hc_halo_fold_least(hc_halo *halo, hc_field_type type, int components, void *values,
                        const uint64_t *chosen);

/* What to add to the low words of positions in a copy of a cell. Local. */
static inline void hc_halo_shift(const hc_halo *halo, const hc_halo_cell *cell, uint32_t shift[3]) {
  for (int axis = 0; axis < 3; axis++)
    shift[axis] = (uint32_t)(uint64_t)(cell->shift[axis] * halo->domain->frame->period[axis]);
}

/* What a refresh of such fields takes for each particle, bytes. */
size_t hc_halo_bytes(hc_field_set fields);

#endif
