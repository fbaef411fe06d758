/* Samples chosen among candidates so that they are evenly spread: see surface_samples.h for the method.
 *
 * Each part has a share of the candidates, and all have all samples: what a part finds among its candidates,
 * all parts get together in the order of the candidates. So the samples are the same to the bit however many
 * parts there are. Collective over the parts, where they are named; everything goes by index. */
#ifndef HC_SAMPLE_CHOICE_H
#define HC_SAMPLE_CHOICE_H

#include "parts.h"
#include "sample_set.h"

typedef struct hc_sample_candidate {
  double x[3];
  int32_t triangle;
  int32_t nearest; /* sample, of the last round; below 0: not known */
} hc_sample_candidate;

typedef struct hc_sample_candidates {
  hc_sample_candidate *at;
  int32_t count;
  size_t room;
  int64_t first, all; /* ours are from `first` on of all: set by hc_sample_candidates_number */
} hc_sample_candidates;

/* None yet, with room for so many; freed with hc_sample_candidates_free. */
hc_sample_candidates hc_sample_candidates_make(int64_t room);
void hc_sample_candidates_free(hc_sample_candidates *candidates);

void hc_sample_candidates_add(hc_sample_candidates *candidates, const double x[3], int32_t triangle);

/* Counts those of all parts, which must be no more than 2^31 - 64. */
void hc_sample_candidates_number(hc_sample_candidates *candidates, const hc_parts *parts);

/* Takes candidates, in an order that is shuffled by a fixed rule, that are not within `distance` of samples
 * taken before. */
void hc_sample_choice_first(hc_sample_set *set, hc_sample_candidates *candidates, double distance,
                            const hc_parts *parts);

/* A round of Lloyd's algorithm. */
void hc_sample_choice_even_out(hc_sample_set *set, hc_sample_candidates *candidates, const hc_parts *parts);

/* Drops samples within `distance` of earlier ones; the fixed stay. Local. */
void hc_sample_choice_thin_out(hc_sample_set *set, hc_sample_candidates *candidates, double distance);

/* Takes candidates that are farther than `distance` from all samples, the farthest first. */
void hc_sample_choice_fill(hc_sample_set *set, const hc_sample_candidates *candidates, double distance,
                           const hc_parts *parts);

#endif
