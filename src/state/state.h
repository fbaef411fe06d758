/* A run's state: everything that the next step reads, registered in one place and walked by one visitor.
 *
 * State is of two sorts. Items are plain numbers that every rank holds alike (the time, the step's history,
 * averages under way); whoever owns one registers it by name. Fields are the particles' rows of fields.def
 * that are marked HC_STATE; each rank holds those of its own particles. Checkpoints, restarts, copies in
 * memory (copy.h) and the digest are visitors of the same list, so that none of them can forget a thing that
 * another knows. */
#ifndef HC_STATE_H
#define HC_STATE_H

#include "particles/particles.h"

enum { HC_STATE_NAME = 48 };

/* An item: `count` numbers of one type (HC_TYPE_i64, HC_TYPE_u64, HC_TYPE_f64) at `data`, the owner's. */
typedef struct hc_state_item {
  char name[HC_STATE_NAME];
  hc_field_type type;
  int count;
  void *data;
} hc_state_item;

enum { HC_STATE_MOST_STORES = 8 };

typedef struct hc_state {
  hc_particles *stores[HC_STATE_MOST_STORES]; /* the owner's, one of a kind; visited in this order */
  int store_count;
  hc_state_item *items;
  int item_count;
  size_t item_capacity;
} hc_state;

/* A state without items and stores. Freed with hc_state_free. Local. */
void hc_state_init(hc_state *state);
void hc_state_free(hc_state *state);

/* Adds a store, which must stay where it is as long as the state lives. Local. */
void hc_state_add_store(hc_state *state, hc_particles *store);

/* Is the store of a sort that `kinds` names: HC_FLUID, HC_BOUNDARY (walls that stand still), HC_MOVED,
 * HC_INFLOW, HC_WINDOW? */
bool hc_state_names(unsigned kinds, const hc_particles *store);

/* Registers an item, which must stay where it is as long as the state lives. Names are unique. Local. */
void hc_state_add(hc_state *state, hc_field_type type, int count, void *data, const char *name, ...)
    __attribute__((format(printf, 5, 6)));

/* What goes through a state. Both functions may read or write the data; null: that sort is passed over. */
typedef struct hc_state_visitor {
  void *context;
  void (*item)(void *context, const hc_state_item *item);
  void (*field)(void *context, hc_particles *particles, hc_field_id field);
} hc_state_visitor;

/* Visits all items in the order of their registration, then the state fields of the stores of `kinds`
 * (see hc_state_names), in the order of fields.def. Local. */
void hc_state_visit(const hc_state *state, unsigned kinds, const hc_state_visitor *visitor);

/* A number that tells states apart: the same for the same items and the same particles, whatever rank holds
 * them and in whatever order. This rank's share; the ranks' shares are to be added (they wrap around), items
 * count once. Local. */
uint64_t hc_state_digest_items(const hc_state *state);
uint64_t hc_state_digest_particles(const hc_state *state, unsigned kinds);

#endif
