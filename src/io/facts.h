/* What every file of particles says of itself, as attributes of its group /Halocline (list: snapshot.h).
 * Collective over the ranks that share the file, with the same values. */
#ifndef HC_FACTS_H
#define HC_FACTS_H

#include "h5.h"
#include "scene/scene.h"
#include "state/moment.h"

enum { HC_FACTS_FORMAT = 1 }; /* the attribute format_version */

/* The moment and its setting; `fluid` and `boundary` count the particles of all ranks. */
void hc_facts_put(hid_t group, const hc_scene *scene, const hc_moment *moment, int64_t fluid,
                  int64_t boundary, hc_error *problem);

/* Units and kinds of fields (hc_field_id): groups `units` and `kinds` below the group. */
void hc_facts_put_fields(hid_t group, const int *fields, int count, hc_error *problem);

#endif
