/* The inside of a checkpoint file (see checkpoint.h), written by checkpoint.c, read by restarts. */
#ifndef HC_CHECKPOINT_CONTENT_H
#define HC_CHECKPOINT_CONTENT_H

#include "comm/comm.h"
#include "h5.h"
#include "scene/scene.h"
#include "state/moment.h"
#include "state/state.h"

typedef struct hc_checkpoint_content {
  hc_comm *comm;
  const hc_scene *scene;
  const hc_moment *moment;
  const hc_state *state;
  const char *instruction_set, *scene_text;
  int64_t total[HC_STATE_MOST_STORES], first[HC_STATE_MOST_STORES]; /* rows of all ranks, this rank's first */
} hc_checkpoint_content;

/* Fills total and first. Collective. */
void hc_checkpoint_content_count(hc_checkpoint_content *content);

/* Bytes that the file can have at most, headers included. Local. */
int64_t hc_checkpoint_content_bytes(const hc_checkpoint_content *content);

/* Writes everything into an open file. Collective; may set this rank's `problem`. */
void hc_checkpoint_content_write(const hc_checkpoint_content *content, hid_t file, hc_error *problem);

/* What a restart needs to know before it reads the state. This and the next function must only be given files
 * that hc_seal_check has found whole. */
typedef struct hc_checkpoint_facts {
  char *scene_text; /* zero-terminated; hc_free */
  char instruction_set[32];
  int64_t ranks; /* that wrote it */
} hc_checkpoint_facts;

/* Collective; HC_IO_FAILED, agreed. */
hc_status hc_checkpoint_facts_read(hc_comm *comm, const char *path, hc_checkpoint_facts *facts,
                                   hc_error *error);

/* Fills the state's items and gives each rank a share of the particles (whoever's they are: distribute them
 * afterwards); ghosts are gone. The items registered must be those of the file. Collective; HC_IO_FAILED,
 * agreed, then the state is undefined. */
hc_status hc_checkpoint_read(hc_comm *comm, const char *path, hc_state *state, hc_error *error);

#endif
