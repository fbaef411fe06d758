/* Reading a snapshot, whole columns at a time, in one process (no MPI needed). Used by `diff`, `info` and
 * tests.
 *
 * Everything here is local. A file that is missing, not HDF5, not a Halocline snapshot, cut short or
 * inconsistent is HC_BAD_INPUT with the path and the reason. Returned arrays are the caller's (hc_free). */
#ifndef HC_SNAPSHOT_READ_H
#define HC_SNAPSHOT_READ_H

#include "halocline/error.h"
#include "scene/scene.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { HC_SNAPSHOT_READ_FIELDS = 64, HC_SNAPSHOT_READ_NAME = 64 };

typedef enum hc_snapshot_type {
  HC_SNAPSHOT_U8,
  HC_SNAPSHOT_I64,
  HC_SNAPSHOT_F32,
  HC_SNAPSHOT_F64
} hc_snapshot_type;

/* A column of values, except `id` (and a checkpoint's `position`). */
typedef struct hc_snapshot_field {
  char name[HC_SNAPSHOT_READ_NAME], unit[HC_SNAPSHOT_READ_NAME];
  hc_snapshot_type type;
  int components;
  size_t bytes;   /* of all components of one particle */
  unsigned kinds; /* HC_FLUID | HC_BOUNDARY: who has it; the others hold zeros */
} hc_snapshot_field;

/* What the attributes say; see snapshot.h. */
typedef struct hc_snapshot_facts {
  char scene[HC_NAME_LENGTH], program_version[HC_SNAPSHOT_READ_NAME];
  int64_t format_version, step;
  double time, dt, particle_spacing, support_radius, rest_density, gravity[3];
  double particle_mass;                 /* kg; NaN: an older file, which does not tell */
  double unit[3];                       /* m */
  int64_t origin[3], period[3], low[3]; /* units */
  int64_t particles, fluid, boundary;
  int64_t moving; /* of the boundary, in checkpoints: of walls that move */
  int64_t pieces; /* ranks that wrote it */
} hc_snapshot_facts;

typedef struct hc_snapshot_file {
  char path[4096];
  int64_t handle;  /* HDF5's */
  bool checkpoint; /* not a snapshot: state fields by kind, fluid first */
  hc_snapshot_facts facts;
  hc_snapshot_field fields[HC_SNAPSHOT_READ_FIELDS]; /* sorted by name */
  int field_count;
} hc_snapshot_file;

/* Opens a snapshot or a checkpoint and checks that its parts fit together. Closed with
 * hc_snapshot_read_close; after a failure there is nothing to close. */
hc_status hc_snapshot_read_open(const char *path, hc_snapshot_file *file, hc_error *error);
void hc_snapshot_read_close(hc_snapshot_file *file);

/* facts.particles values, in the order of the file. */
hc_status hc_snapshot_read_ids(const hc_snapshot_file *file, uint64_t **ids, hc_error *error);

/* Points in metres, [particles][3]. */
hc_status hc_snapshot_read_points(const hc_snapshot_file *file, double **points, hc_error *error);

/* Positions in units relative to the scene's origin, [particles][3]: exactly what the simulation held, as
 * long as they are below 2^48 units. */
hc_status hc_snapshot_read_positions(const hc_snapshot_file *file, int64_t **positions, hc_error *error);

/* All components of one field (an element of file->fields), [particles][components] of its type. */
hc_status hc_snapshot_read_field(const hc_snapshot_file *file, const hc_snapshot_field *field, void **values,
                                 hc_error *error);
/* Value k of such an array as a double. */
double hc_snapshot_read_value(const void *values, hc_snapshot_type type, int64_t k);

/* The field of a name, or null. */
const hc_snapshot_field *hc_snapshot_read_find(const hc_snapshot_file *file, const char *name);

/* Fluid and boundary particles of each piece, [pieces][2]. */
hc_status hc_snapshot_read_pieces(const hc_snapshot_file *file, int64_t **counts, hc_error *error);

#endif
