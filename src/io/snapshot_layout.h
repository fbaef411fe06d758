/* The inside of a snapshot file: its groups, attributes and datasets. Used by snapshot.c only; see snapshot.h
 * for the layout. Definition, then data: between the two the file's size is known and its blocks can be
 * reserved. */
#ifndef HC_SNAPSHOT_LAYOUT_H
#define HC_SNAPSHOT_LAYOUT_H

#include "comm/comm.h"
#include "h5.h"
#include "scene/scene.h"
#include "state/moment.h"

/* A dataset and where this rank's rows lie in it. */
typedef struct hc_snapshot_column {
  hid_t dataset;
  int field;     /* hc_field_id, or -1 */
  int64_t first; /* row */
  int64_t count; /* rows of this rank */
  int64_t rows;  /* of all ranks */
} hc_snapshot_column;

enum { HC_SNAPSHOT_MAX_FIELDS = HC_MAX_SNAPSHOT_FIELDS + 1 /* id */ };

typedef struct hc_snapshot_layout {
  hc_comm *comm;
  const hc_scene *scene;
  const hc_moment *moment;
  int64_t (*counts)[2];                /* fluid and boundary particles of every rank */
  int64_t fluid, boundary;             /* of all ranks */
  hid_t file, independent, collective; /* transfer modes */
  int fields[HC_SNAPSHOT_MAX_FIELDS], field_count;
  hc_snapshot_column points, connectivity, offsets, types, kind, field[HC_SNAPSHOT_MAX_FIELDS];
  hc_snapshot_column per_piece[4]; /* points, cells, connectivity, fluid: rank 0 writes them */
  hc_error *problem;               /* this rank's first failure */
} hc_snapshot_layout;

/* Gathers the counts and resolves the requested fields. Collective, may set `problem` (HC_BAD_INPUT). */
void hc_snapshot_layout_init(hc_snapshot_layout *layout, hc_comm *comm, const hc_scene *scene,
                             const hc_moment *moment, hc_error *problem);
void hc_snapshot_layout_free(hc_snapshot_layout *layout);

/* Bytes that the file can have at most, headers included. Local. */
int64_t hc_snapshot_layout_bytes(const hc_snapshot_layout *layout);

/* See hc_snapshot_bytes. Local; may set `problem`. */
int64_t hc_snapshot_layout_estimate(const hc_scene *scene, int64_t particles, hc_error *problem);

/* Creates groups, attributes and datasets in layout->file. Collective; may set `problem`. */
void hc_snapshot_layout_define(hc_snapshot_layout *layout);

/* Writes all data. Collective: returns early on all ranks together once one has a problem (agreed: `problem`
 * is everybody's). */
void hc_snapshot_layout_fill(hc_snapshot_layout *layout);

/* Closes the datasets; the file stays open. */
void hc_snapshot_layout_close(hc_snapshot_layout *layout);

#endif
