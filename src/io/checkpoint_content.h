/* The inside of a checkpoint file (see checkpoint.h). Used by checkpoint.c only. */
#ifndef HC_CHECKPOINT_CONTENT_H
#define HC_CHECKPOINT_CONTENT_H

#include "checkpoint.h"
#include "h5.h"

typedef struct hc_checkpoint_content {
  hc_comm *comm;
  const hc_snapshot *moment;
  const hc_state *state;
  const char *instruction_set, *scene_text;
  int64_t total[2], first[2]; /* fluid, boundary: rows of all ranks, this rank's first */
} hc_checkpoint_content;

/* Fills total and first. Collective. */
void hc_checkpoint_content_count(hc_checkpoint_content *content);

/* Bytes that the file can have at most, headers included. Local. */
int64_t hc_checkpoint_content_bytes(const hc_checkpoint_content *content);

/* Writes everything into an open file. Collective; may set this rank's `problem`. */
void hc_checkpoint_content_write(const hc_checkpoint_content *content, hid_t file, hc_error *problem);

#endif
