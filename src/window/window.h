/* The dynamic window: a container that follows a body over an endless ocean (Carensac et al. 2023, section
 * 4.1). Once the body has got farther from its place in the window than a distance, the container goes along,
 * across gravity, by whole spacings: so its samples come to the places of others where it looks the same.
 *
 * Water is renewed where the wall is another one than before: outside of where it was, near to where its
 * sides were and near to where they come to. There the fluid goes, and what stood there at the start comes
 * instead, which fits the wall: the places, all fluid of the start and the air above it. Readings: a floor
 * that the wall has before and behind is no boundary to keep away from, else the paper's distances would
 * renew all water above it.
 *
 * How far the window has come, and how often it has gone along, is state; places and the wall's samples
 * follow from it (hc_window_pose). */
#ifndef HC_WINDOW_H
#define HC_WINDOW_H

#include "rigid/bodies.h"
#include "setup/populate.h"
#include "sources/places.h"

/* Zeroed: there is none. */
typedef struct hc_window {
  bool there;
  int body;                                   /* its number */
  hc_shape shape;                             /* the container, where the scene puts it */
  bool goes[3];                               /* the axes along which it goes */
  double trigger, old_distance, new_distance; /* m */
  int64_t start[3];                           /* units: of the body at the start */
  int64_t shift[3];                           /* units: how far the window has come; state */
  int64_t count;                              /* how often it has gone along; state */
  int64_t before[3];                          /* the shift before the last time */
  uint64_t source;                            /* in ids of what comes in */
  hc_sample_numbers samples;                  /* of the start */
  hc_places places; /* fluid and air of the start, gone along as the wall's samples have; ids: kind and number
                     */
} hc_window;

/* `plan` is that of the same scene, as are the bodies. Freed with hc_window_free. HC_BAD_INPUT: a body too
 * near to the wall for the window to go along; more samples than ids have room for. Local. */
hc_status hc_window_make(const hc_scene *scene, const hc_setup_plan *plan, const hc_bodies *bodies,
                         hc_window *window, hc_error *error);
void hc_window_free(hc_window *window);

/* Registers what is state. Local. */
void hc_window_register(hc_window *window, hc_state *state);

/* Makes places of the air, or of the fluid, that the world's store holds at the start of a run. Local. */
void hc_window_remember(hc_window *window, const hc_world *world, hc_id_kind kind);

/* After a restart: places and walls are read as they stood. Local. */
void hc_window_adopt(hc_window *window);

/* Puts walls and places where the window has come to; hc_world_place must follow. Local. */
void hc_window_pose(hc_window *window, hc_world *world);

/* Does the window go along now? Then its shift is the next one, and hc_window_pose must follow. HC_FAILED if
 * the body has left it, or no ids are left. Local, the same on every rank. */
bool hc_window_decide(hc_window *window, const hc_frame *frame, const hc_bodies *bodies, hc_error *error);

/* Behind it: takes out fluid where it is to be renewed, and puts in what stands there at rest, with its air.
 * Returns the ids of what has come, [from, to). Collective: places go to their owners. */
void hc_window_renew(hc_window *window, hc_world *world, uint64_t *from, uint64_t *to);

#endif
