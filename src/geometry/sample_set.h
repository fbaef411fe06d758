/* Samples chosen among candidates so that they are evenly spread: see surface_samples.h for the method.
 * Local; everything goes by index, never by address or the order of a hash table. */
#ifndef HC_SAMPLE_SET_H
#define HC_SAMPLE_SET_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct hc_sample {
  double x[3], normal[3];
  int32_t triangle; /* that it comes from; -1: none */
  int32_t next;     /* in its chain of the grid; -1: the last */
} hc_sample;

/* The samples, and a grid that finds them. */
typedef struct hc_sample_set {
  hc_sample *at;
  int32_t count, fixed; /* of all; those that stay */
  size_t room;
  double reach;   /* what is farther need not be found */
  double edge;    /* of a cell of the grid */
  int32_t *heads; /* of chains of samples, by the hash of their cell */
  int32_t head_count;
} hc_sample_set;

typedef struct hc_sample_candidate {
  double x[3];
  int32_t triangle;
  int32_t nearest; /* sample, of the last round */
} hc_sample_candidate;

typedef struct hc_sample_candidates {
  hc_sample_candidate *at;
  int32_t count;
  size_t room;
} hc_sample_candidates;

hc_sample_set hc_sample_set_make(double reach);
void hc_sample_set_free(hc_sample_set *set);
void hc_sample_set_add(hc_sample_set *set, const double x[3], const double normal[3], int32_t triangle);

/* Is there a sample closer than `distance`, at most the set's reach? */
bool hc_sample_set_any_within(const hc_sample_set *set, const double x[3], double distance);

/* None yet, with room for so many; freed with hc_sample_candidates_free. */
hc_sample_candidates hc_sample_candidates_make(int64_t room);
void hc_sample_candidates_free(hc_sample_candidates *candidates);

void hc_sample_candidates_add(hc_sample_candidates *candidates, const double x[3], int32_t triangle);

/* Takes candidates, in an order that is shuffled by a fixed rule, that are not within `distance` of samples
 * taken before. */
void hc_sample_set_choose(hc_sample_set *set, hc_sample_candidates *candidates, double distance);

/* A round of Lloyd's algorithm. */
void hc_sample_set_even_out(hc_sample_set *set, hc_sample_candidates *candidates);

/* Drops samples within `distance` of earlier ones; the fixed stay. */
void hc_sample_set_thin_out(hc_sample_set *set, hc_sample_candidates *candidates, double distance);

/* Takes candidates that are farther than `distance` from all samples, the farthest first. */
void hc_sample_set_fill(hc_sample_set *set, const hc_sample_candidates *candidates, double distance);

#endif
