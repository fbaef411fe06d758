/* The particle store: one structure of arrays for the fluid, one for the boundary, both described by
 * fields.def.
 *
 * Local indices are int32_t. [0, border) are own particles next to another rank's (or a periodic image's)
 * cells, [border, own) own interior ones, [own, own + ghosts) copies of other ranks' particles; behind them
 * the arrays with ghosts have HC_SPARE more elements that may be read (they keep vector loads in bounds). */
#ifndef HC_PARTICLES_H
#define HC_PARTICLES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* 16 bytes that a pair sweep loads at once: place (x, y, z as int32_t, scalar) or motion (vx, vy, vz,
 * scalar). */
typedef struct hc_record {
  union {
    int32_t x[3];
    float v[3];
  };
  float scalar;
} hc_record;

typedef int64_t hc_field_i64;
typedef uint64_t hc_field_u64;
typedef double hc_field_f64;
typedef float hc_field_f32;
typedef hc_record hc_field_record;

typedef enum hc_field_type {
  HC_TYPE_i64,
  HC_TYPE_u64,
  HC_TYPE_f64,
  HC_TYPE_f32,
  HC_TYPE_record
} hc_field_type;

enum { HC_FLUID = 1, HC_BOUNDARY = 2, HC_GHOST = 4, HC_STATE = 8, HC_SNAPSHOT = 16 };

typedef enum hc_field_id {
#define HC_FIELD(name, type, components, flags, unit, sentence) HC_FIELD_##name,
#include "fields.def"
#undef HC_FIELD
  HC_FIELD_COUNT
} hc_field_id;

typedef struct hc_field_info {
  const char *name;
  hc_field_type type;
  int components;
  size_t bytes; /* of all components of one particle */
  unsigned flags;
  const char *unit, *sentence;
} hc_field_info;

extern const hc_field_info hc_fields[HC_FIELD_COUNT];

enum { HC_SPARE = 16 };

typedef struct hc_particles {
  unsigned kind; /* HC_FLUID or HC_BOUNDARY: which fields there are */
  int32_t border, own, ghosts;
  union {
    struct {
#define HC_FIELD(name, type, components, flags, unit, sentence) hc_field_##type *name;
#include "fields.def"
#undef HC_FIELD
    };
    void *data[HC_FIELD_COUNT]; /* the same pointers by hc_field_id; null where the kind lacks the field */
  };
  size_t capacity[HC_FIELD_COUNT];
  void *scratch; /* for permutations, and see hc_particles_scratch */
  size_t scratch_capacity;
} hc_particles;

/* An empty store of one kind. Freed with hc_particles_free. Local. */
void hc_particles_init(hc_particles *particles, unsigned kind);
void hc_particles_free(hc_particles *particles);

/* Changes the number of own particles, keeping the state of the first min(old, new); drops all ghosts and the
 * border. New particles' state is zero. */
void hc_particles_resize(hc_particles *particles, int32_t own);

/* Makes room for `ghosts` copies behind the own range; own values stay. */
void hc_particles_set_ghosts(hc_particles *particles, int32_t ghosts);

/* Reorders the state fields: afterwards particle k is what order[k] was, for k in [0, count), and own =
 * count. Fields that are not state keep no meaning. */
void hc_particles_permute(hc_particles *particles, const int32_t *order, int32_t count);

/* Takes out own particles, by indices in ascending order; particles from the end close the gaps, and ghosts
 * are dropped. Fields that are not state keep no meaning. */
void hc_particles_remove(hc_particles *particles, const int32_t *indices, int32_t count);

/* Work space of `bytes` for each own particle, the store's own; the next permutation overwrites it. */
void *hc_particles_scratch(hc_particles *particles, size_t bytes);

/* Bytes of one particle's state, and copies between a particle and such a packed block. */
size_t hc_particles_state_bytes(unsigned kind);
void hc_particles_pack(const hc_particles *particles, int32_t index, void *block);
void hc_particles_unpack(hc_particles *particles, int32_t index, const void *block);

#endif
