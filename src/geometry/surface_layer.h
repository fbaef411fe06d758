/* A layer of boundary samples behind a surface, and the candidates that samples are chosen from: see
 * surface_samples.h for the method. Local. */
#ifndef HC_SURFACE_LAYER_H
#define HC_SURFACE_LAYER_H

#include "sample_choice.h"
#include "surface.h"

typedef struct hc_surface_layer {
  const hc_surface *surface;
  double spacing, depth;
  double side;        /* 1: the fluid is where the normals point to; -1: on the other side */
  int number;         /* 0: the layer behind the surface */
  double (*mitre)[3]; /* of each vertex: where it goes, over the depth, against the fluid's normal */
} hc_surface_layer;

/* Of the depth: what is less deep in the end is left out. */
static const double hc_surface_layer_deep = 0.93;

/* Refers to the surface; freed with hc_surface_layer_free. */
hc_surface_layer hc_surface_layer_make(const hc_surface *surface, double spacing, int number,
                                       bool fluid_inside);
void hc_surface_layer_free(hc_surface_layer *layer);

/* Where vertex v goes. */
void hc_surface_layer_vertex(const hc_surface_layer *layer, int32_t v, double x[3]);

/* About how many places there are, however many. */
double hc_surface_layer_estimate(const hc_surface_layer *layer);

/* How many places on the faces have a candidate at most: so many that they can be counted. */
int64_t hc_surface_layer_places(const hc_surface_layer *layer);

/* The candidates at the places in [first, last), in their order: those of parts one after the other are those
 * of the whole, to the bit. Freed with hc_sample_candidates_free. */
hc_sample_candidates hc_surface_layer_candidates(const hc_surface_layer *layer, int64_t first, int64_t last);

#endif
