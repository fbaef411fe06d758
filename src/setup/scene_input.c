#include "scene_input.h"

#include "base/memory.h"
#include "setup/bodies.h"
#include "setup/meshes.h"
#include "setup/methods.h"
#include "setup/motions.h"
#include "setup/review.h"

#include <string.h>

/* The files that a scene names. */
static void load_files(void *context, hc_scene *scene, const char *name, hc_findings *findings) {
  const hc_scene_files *const files = context;
  hc_comm *const comm = files ? files->comm : NULL;
  hc_setup_motions_load(comm, scene, name, findings);
  hc_setup_meshes_load(comm, scene, name, findings);
  hc_setup_rest_states_load(files, scene, name, findings);
  hc_setup_bodies_complete(scene, findings);
}

hc_scene_limits hc_scene_input_limits(const char **names, hc_scene_files *files) {
  int count = 0;
  for (int field = 0; field < HC_FIELD_COUNT; field++)
    if ((hc_fields[field].flags & HC_SNAPSHOT) && field != HC_FIELD_id)
      names[count++] = hc_fields[field].name;
  return (hc_scene_limits){.snapshot_fields = names,
                           .snapshot_field_count = count,
                           .complete = hc_setup_complete,
                           .check = hc_setup_review,
                           .load = load_files,
                           .context = files};
}

/* What the ranks must know before the words themselves come. */
typedef struct header {
  size_t text_bytes, word_bytes; /* zeros at the ends included */
  int words;
} header;

/* Name and overrides as one block of words, each with its zero. */
static char *join_words(const hc_scene_input *input, header *header) {
  header->words = 1 + input->override_count;
  header->word_bytes = strlen(input->name) + 1;
  for (int k = 0; k < input->override_count; k++) header->word_bytes += strlen(input->overrides[k]) + 1;
  char *words = hc_alloc(header->word_bytes, 1);
  char *to = stpcpy(words, input->name) + 1;
  for (int k = 0; k < input->override_count; k++) to = stpcpy(to, input->overrides[k]) + 1;
  return words;
}

static hc_status read_words(hc_scene_files *files, const header *header, const char *text, const char *words,
                            hc_scene *scene, hc_warnings *warnings, hc_error *error) {
  const char **each = hc_alloc((size_t)header->words, sizeof *each);
  for (int k = 0; k < header->words; k++, words += strlen(words) + 1) each[k] = words;
  const char *names[HC_FIELD_COUNT];
  const hc_scene_limits limits = hc_scene_input_limits(names, files);
  const hc_status status = hc_scene_read_text(scene, each[0], text, header->text_bytes - 1, each + 1,
                                              header->words - 1, &limits, warnings, error);
  hc_free(each);
  return status;
}

hc_status hc_scene_input_read(hc_comm *comm, const hc_scene_input *input, hc_scene *scene,
                              hc_warnings *warnings, hc_error *error) {
  memset(scene, 0, sizeof *scene);
  char *text = NULL, *words = NULL;
  header header = {0, 0, 0};
  if (comm->rank == 0) {
    size_t length = 0;
    if (!input->text) {
      hc_scene_load(input->name, &text, &length, error);
    } else {
      length = strlen(input->text);
      text = memcpy(hc_alloc(length + 1, 1), input->text, length + 1);
    }
    header.text_bytes = length + 1;
    words = join_words(input, &header);
  }
  if (hc_comm_agree(comm, error) == HC_OK) {
    hc_comm_broadcast(comm, &header, sizeof header, 0);
    if (comm->rank != 0) {
      text = hc_alloc(header.text_bytes, 1);
      words = hc_alloc(header.word_bytes, 1);
    }
    hc_comm_broadcast(comm, text, header.text_bytes, 0);
    hc_comm_broadcast(comm, words, header.word_bytes, 0);
    hc_scene_files files = {comm, input->read_rest};
    read_words(&files, &header, text, words, scene, comm->rank == 0 ? warnings : NULL, error);
    if (hc_comm_agree(comm, error) != HC_OK) hc_scene_free(scene);
  }
  hc_free(text);
  hc_free(words);
  return error->status;
}
