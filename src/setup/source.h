/* A block of fluid or a wall, ready to be sampled. */
#ifndef HC_SOURCE_H
#define HC_SOURCE_H

#include "geometry/sampling.h"
#include "halocline/error.h"
#include "particles/ids.h"
#include "scene/scene.h"
#include "setup/gaps.h"
#include "space/frame.h"

/* A point of a shape at x starts at to + turn (x - from). */
typedef struct hc_start {
  bool moved; /* else it starts where the shape is */
  double turn[3][3];
  double from[3], to[3]; /* m: the centre of mass in the shape, and at the start */
} hc_start;

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
  hc_start start;                   /* bodies: from where the shape is to where they start */
} hc_setup_source;

/* What messages call a source: fluid.blocks[2], boundary.walls[1] "tank". */
typedef struct hc_source_name {
  char text[HC_NAME_LENGTH + 64];
} hc_source_name;

hc_source_name hc_source_block_name(int number);
hc_source_name hc_source_wall_name(const hc_wall *wall, int number);
hc_source_name hc_source_body_name(const hc_scene_body *body, int number);

/* Of a wall or body, by its number among both. */
hc_source_name hc_source_surface_name(const hc_scene *scene, int number);

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
/* The same of the wall or body of that number among both. */
hc_status hc_source_surface(const hc_frame *frame, const hc_scene *scene, int number, int layers,
                            hc_setup_source *source, hc_error *error);
void hc_source_free(hc_setup_source *source);

/* The shape of a wall but a plane, that is well formed. */
hc_shape hc_source_wall_shape(const hc_wall *wall);

/* Puts a point of the sampling, in units, or turns a direction, as a body starts. Local. */
void hc_source_put(const hc_frame *frame, const hc_setup_source *source, int64_t point[3]);
void hc_source_turn(const hc_setup_source *source, double direction[3]);

/* From `x` to the nearest surface on which a wall's samples lie, over all periodic images, m. Local. */
double hc_source_layer_distance(const hc_frame *frame, const hc_setup_source *wall, const double x[3]);

/* The radius of the smallest sphere about the shape's centre that holds all of a wall's layers, m. */
double hc_source_layer_reach(const hc_setup_source *wall);

/* The normal at a wall's sample k, see hc_shape_sample_normal; of a surface's only those held here. Local. */
void hc_source_normal(const hc_frame *frame, const hc_setup_source *wall, int64_t k, double normal[3]);

/* Does a block reach all around the period of an axis? Local. */
bool hc_source_fills_period(const hc_frame *frame, const hc_setup_source *block, int axis);

/* The thickness of the shape where it is thinnest; of a surface that of the box around it, m. */
double hc_source_thickness(const hc_setup_source *source);

/* Particles that the source makes. */
int64_t hc_source_count(const hc_setup_source *source);

/* The smallest box around a block's shape, m. */
hc_box hc_source_block_bounds(const hc_block *block);

#endif
