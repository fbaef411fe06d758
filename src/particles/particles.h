/* The particle stores: a structure of arrays for each set of particles (the fluid, walls that stand still,
 * walls that move), described by fields.def.
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

enum {
  HC_FLUID = 1,
  HC_BOUNDARY = 2,
  HC_MOVED = 4,
  HC_GHOST = 8,
  HC_CARRIED = 16,
  HC_STATE = 32 | HC_CARRIED,
  HC_SNAPSHOT = 64,
  HC_DRIFTING = 128,
  HC_INFLOW = 256, /* places where particles may come in (sources/absorption.h) */
  HC_WINDOW = 512, /* places of the fluid with which a window is filled (simulation/displace.h) */
  HC_PLACES = HC_INFLOW | HC_WINDOW
};

/* What a run does with its particles, as far as fields depend on it. */
enum {
  HC_FOR_DFSPH = 1,
  HC_FOR_PCISPH = 2,
  HC_FOR_WALL_VOLUMES = 4, /* walls count by their volumes (akinci2012) */
  HC_FOR_RIGID_WALLS = 8,  /* walls have contact and normals (ihmsen2010 and others) */
  HC_FOR_MOVERS = 16,      /* walls move */
  HC_FOR_WCSPH = 32,
  HC_FOR_INDIVIDUAL = 64, /* particles have time steps of their own */
  HC_FOR_ALL = 127
};

typedef enum hc_field_id {
#define HC_FIELD(name, type, components, flags, needs, unit, sentence) HC_FIELD_##name,
#include "fields.def"
#undef HC_FIELD
  HC_FIELD_COUNT
} hc_field_id;

typedef struct hc_field_info {
  const char *name;
  hc_field_type type;
  int components;
  size_t bytes; /* of all components of one particle */
  unsigned flags, needs;
  const char *unit, *sentence;
} hc_field_info;

extern const hc_field_info hc_fields[HC_FIELD_COUNT];

/* Fields by name, as sets: of the whole row, or of the scalar of its record. */
typedef uint64_t hc_field_set;
#define HC_WHOLE(name) ((hc_field_set)1 << HC_FIELD_##name)
#define HC_SCALAR(name) ((hc_field_set)1 << (32 + HC_FIELD_##name))
_Static_assert(HC_FIELD_COUNT <= 32, "a set of fields has a bit for each row, and one for its scalar");

/* Has a set of particles of a kind this field, in a run with these features? Have ghosts it then? Is it
 * state? */
static inline bool hc_field_is_there(const hc_field_info *info, unsigned kind, unsigned features) {
  return (info->flags & kind) && (!info->needs || (info->needs & features));
}
static inline bool hc_field_has_ghosts(const hc_field_info *info, unsigned features) {
  return (info->flags & HC_GHOST) || ((info->flags & HC_DRIFTING) && (features & HC_FOR_INDIVIDUAL));
}
static inline bool hc_field_is_state(const hc_field_info *info) {
  return (info->flags & HC_STATE) == HC_STATE;
}

enum { HC_SPARE = 16 };

/* What set-up gives a rank at most of a kind, and lists reach, ghosts included: their entries are 32 bits and
 * count bytes of records. */
#define HC_RECORDS_MOST ((int64_t)UINT32_MAX / (int64_t)sizeof(hc_record) - 64)

typedef struct hc_particles {
  unsigned
      kind; /* which fields there are: HC_FLUID, HC_BOUNDARY, HC_BOUNDARY | HC_MOVED, or one of HC_PLACES */
  unsigned features; /* HC_FOR_*, of the run */
  int32_t border, own, ghosts;
  union {
    struct {
#define HC_FIELD(name, type, components, flags, needs, unit, sentence) hc_field_##type *name;
#include "fields.def"
#undef HC_FIELD
    };
    void *data[HC_FIELD_COUNT]; /* the same pointers by hc_field_id; null where the store lacks the field */
  };
  size_t capacity[HC_FIELD_COUNT];
  struct hc_particles *head, *tail; /* see hc_particles_join; mostly null */
  hc_field_set under_way;           /* fields whose ghosts are being refreshed: nobody may read them */
  void *scratch;                    /* for permutations, and see hc_particles_scratch */
  size_t scratch_capacity;
} hc_particles;

/* An empty store of one kind, with the fields that a run of these features needs. Freed with
 * hc_particles_free. Local. */
void hc_particles_init(hc_particles *particles, unsigned kind, unsigned features);
void hc_particles_free(hc_particles *particles);

/* Lets the records (place, motion, facing) of `tail`, own and ghosts, stand behind those of `head`, in the
 * same arrays: so one index reaches both, that of a particle of the tail being hc_particles_first(tail) more
 * than its own. What changes the head's size leaves the tail's records undefined. Both empty; they must stay
 * where they are, and the tail be freed first. */
void hc_particles_join(hc_particles *head, hc_particles *tail);

/* The index of the first particle of a store among the records it shares; 0 for others. */
static inline int32_t hc_particles_first(const hc_particles *particles) {
  return particles->head ? particles->head->own + particles->head->ghosts : 0;
}

/* Changes the number of own particles, keeping what the first min(old, new) carry; drops all ghosts and the
 * border. What new particles carry is zero. */
void hc_particles_resize(hc_particles *particles, int32_t own);

/* Makes room for `ghosts` copies behind the own range; own values stay. */
void hc_particles_set_ghosts(hc_particles *particles, int32_t ghosts);

/* Reorders the carried fields: afterwards particle k is what order[k] was, for k in [0, count), and own =
 * count. Other fields keep no meaning. */
void hc_particles_permute(hc_particles *particles, const int32_t *order, int32_t count);

/* Takes out own particles, by indices in ascending order; particles from the end close the gaps, and ghosts
 * are dropped. Fields that are not carried keep no meaning. */
void hc_particles_remove(hc_particles *particles, const int32_t *indices, int32_t count);

/* Work space of `bytes` for each own particle, the store's own; the next permutation overwrites it, but for a
 * word for each particle at its beginning, where the order may stand. Trim gives it back. */
void *hc_particles_scratch(hc_particles *particles, size_t bytes);
void hc_particles_trim(hc_particles *particles);

/* Bytes of what one particle carries, and copies between a particle and such a packed block. */
size_t hc_particles_block_bytes(const hc_particles *particles);
void hc_particles_pack(const hc_particles *particles, int32_t index, void *block);
void hc_particles_unpack(hc_particles *particles, int32_t index, const void *block);

/* Bytes of one particle's state, as checkpoints hold it; and of all its fields. */
size_t hc_particles_state_bytes(unsigned kind, unsigned features);
size_t hc_particles_bytes(unsigned kind, unsigned features);

#endif
