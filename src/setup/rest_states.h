/* Rest states that a scene's blocks name: read, held against the scene, and ready to fill shapes. */
#ifndef HC_REST_STATES_H
#define HC_REST_STATES_H

#include "comm/comm.h"
#include "scene/findings.h"
#include "scene/scene.h"
#include "state/rest_state.h"

/* Reads the file at `path`; io/rest_file.h. Local. */
typedef hc_status (*hc_rest_reader)(const char *path, hc_rest_state **state, hc_error *error);

/* Files that a scene names, and who reads them. */
typedef struct hc_scene_files {
  hc_comm *comm;            /* rank 0 reads and sends; null: this process alone */
  hc_rest_reader read_rest; /* null: scenes with rest states are refused */
} hc_scene_files;

/* Reads the rest state of every block that names one. Files' paths become whole and their checksums are
 * filled in. Errors, as findings: what the reader refuses; another checksum, particle spacing, support
 * radius, density, mass or solver than the scene's; fluid that is not at rest, or denser than rest; a block
 * that reaches beyond one that is not periodic, or around a period of the scene that is no multiple of its
 * own. Collective where there is a comm. */
void hc_setup_rest_states_load(const hc_scene_files *files, hc_scene *scene, const char *name,
                               hc_findings *findings);

/* Does any block have one at the start? Or one that comes later? Local. */
bool hc_setup_has_rest_states(const hc_scene *scene);
bool hc_setup_has_refills(const hc_scene *scene);

/* Frees what only the start of a run has needed, surfaces and rest states: not where blocks come later,
 * walls absorb or a window goes along. Local. */
void hc_setup_free_start(hc_scene *scene);

#endif
