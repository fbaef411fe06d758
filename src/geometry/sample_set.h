/* Samples, and a grid that finds them: see surface_samples.h for the method. Local; everything goes by index,
 * never by address or the order of a hash table. */
#ifndef HC_SAMPLE_SET_H
#define HC_SAMPLE_SET_H

#include "vector.h"

#include <stddef.h>
#include <stdint.h>

typedef struct hc_sample {
  double x[3];
  int32_t triangle; /* that it comes from; below 0: none */
  int32_t next;     /* in its chain of the grid; -1: the last */
} hc_sample;

typedef struct hc_sample_set {
  hc_sample *at;
  int32_t count, fixed; /* of all; those that stay */
  size_t room;
  double reach;   /* what is farther need not be found */
  double edge;    /* of a cell of the grid */
  int32_t *heads; /* of chains of samples, by the hash of their cell */
  int32_t head_count;
  double (*changed)[3]; /* places where samples came, went, moved from and to, since the last round */
  size_t changed_count, changed_room;
} hc_sample_set;

hc_sample_set hc_sample_set_make(double reach);
void hc_sample_set_free(hc_sample_set *set);
void hc_sample_set_add(hc_sample_set *set, const double x[3], int32_t triangle);

/* All samples into a grid of their number: after they have moved, or some are gone. */
void hc_sample_set_link(hc_sample_set *set);

/* A sample closer than `distance`, at most the set's reach; -1: there is none. */
int32_t hc_sample_set_within(const hc_sample_set *set, const double x[3], double distance);

/* The nearest sample within the set's reach, or -1; of several as near the first. `*square`: how near. */
int32_t hc_sample_set_nearest(const hc_sample_set *set, const double x[3], double *square);

static inline double hc_sample_set_square(const hc_sample_set *set, int32_t s, const double x[3]) {
  double away[3];
  hc_vector_minus(set->at[s].x, x, away);
  return hc_vector_dot(away, away);
}

/* The others nearer than an edge: those of a sample are `count` of `with` from `first` on. They are looked
 * for when they are asked for, -1 before that, so that what is near in space lies together. What is nearer to
 * a sample than half the way to the nearest of them is nearer to no other. */
typedef struct hc_sample_near {
  double nearest; /* square */
  int32_t first, count;
} hc_sample_near;

typedef struct hc_sample_neighbors {
  hc_sample_near *of; /* each sample */
  int32_t *with, end;
  size_t room;
  double most; /* square of an edge */
} hc_sample_neighbors;

/* Good as long as no sample moves, comes or goes. */
hc_sample_neighbors hc_sample_neighbors_make(const hc_sample_set *set);
void hc_sample_neighbors_free(hc_sample_neighbors *n);

/* As hc_sample_set_nearest; from a guess (-1: none) to its neighbours as long as that comes nearer. */
int32_t hc_sample_neighbors_nearest(const hc_sample_set *set, hc_sample_neighbors *n, const double x[3],
                                    int32_t guess);

#endif
