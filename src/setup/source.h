/* A block of fluid or a wall, ready to be sampled. */
#ifndef HC_SOURCE_H
#define HC_SOURCE_H

#include "geometry/sampling.h"
#include "halocline/error.h"
#include "particles/ids.h"
#include "scene/scene.h"
#include "setup/gaps.h"
#include "space/frame.h"

typedef struct hc_setup_source {
  hc_sampling sampling;
  hc_gaps gaps; /* samples of it that are left out */
  hc_id_kind kind;
  int64_t number;                   /* place in fluid.blocks or boundary.walls */
  int64_t first;                    /* particles of the same kind before it */
  double velocity[3];               /* m/s; 0 for walls */
  double gradient[3][3], centre[3]; /* 1/s, m: gradient (x - centre) is added to it */
  hc_flow flow;                     /* added to it */
  hc_shape shape;                   /* the block, or the wall's wetted surface */
  hc_shape layer[2];                /* walls: the surfaces on which the samples lie */
  int layers;                       /* walls: how many of them */
  double off;                       /* walls: spacings by which samples may lie off their layer */
  bool solid;                       /* walls: an obstacle */
  int64_t moves;                    /* walls that move: number + 1; 0: it stands */
} hc_setup_source;

/* What messages call a source: fluid.blocks[2], boundary.walls[1] "tank". */
typedef struct hc_source_name {
  char text[HC_NAME_LENGTH + 64];
} hc_source_name;

hc_source_name hc_source_block_name(int number);
hc_source_name hc_source_wall_name(const hc_wall *wall, int number);

/* How many layers of samples the scene's walls have, 1 or 2: boundary.layers, or what its method asks for.
 * Local. */
int hc_setup_layers(const hc_scene *scene);

/* A block's linear velocity field, 1/s: its gradient and its rotation together. Local. */
void hc_source_block_gradient(const hc_block *block, double gradient[3][3]);

/* Fill a source from entry `number` of the scene, a wall with so many layers; `first` stays 0 and no samples
 * are left out. To be freed with hc_source_free, also after an error: see hc_setup_plan_make for these.
 * Local.
 */
hc_status hc_source_block(const hc_frame *frame, const hc_block *block, int number, hc_setup_source *source,
                          hc_error *error);
hc_status hc_source_wall(const hc_frame *frame, const hc_wall *wall, int number, int layers,
                         hc_setup_source *source, hc_error *error);
void hc_source_free(hc_setup_source *source);

/* From `x` to the nearest surface on which a wall's samples lie, over all periodic images, m. Local. */
double hc_source_layer_distance(const hc_frame *frame, const hc_setup_source *wall, const double x[3]);

/* The radius of the smallest sphere about the shape's centre that holds all of a wall's layers, m. */
double hc_source_layer_reach(const hc_setup_source *wall);

/* The normal at a wall's sample k, see hc_shape_sample_normal; of a surface's only those held here. Local. */
void hc_source_normal(const hc_frame *frame, const hc_setup_source *wall, int64_t k, double normal[3]);

/* Particles that the source makes. */
int64_t hc_source_count(const hc_setup_source *source);

/* The smallest box around a block's shape, m. */
hc_box hc_source_block_bounds(const hc_block *block);

#endif
