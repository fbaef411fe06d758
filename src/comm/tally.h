/* A tally: sums and maxima of several parties, reduced together.
 *
 * Each party says where its values are; hc_tally_reduce puts those of all ranks there, in one reduction.
 * Sums are of integers, or exact; of zeros +0 is the largest: so the result is the same on any number of
 * ranks. Doubles must be numbers, or infinite. All ranks must note the same kinds and counts in the same
 * order. The values must stay where they are until the reduction. */
#ifndef HC_TALLY_H
#define HC_TALLY_H

#include "comm.h"

enum { HC_TALLY_MOST = 32 };

typedef enum hc_tally_kind {
  HC_TALLY_SUM_EXACT,
  HC_TALLY_SUM_I64,
  HC_TALLY_MAX_I64,
  HC_TALLY_MAX_F64
} hc_tally_kind;

/* Starts zeroed; needs no freeing. */
typedef struct hc_tally {
  struct {
    hc_tally_kind kind;
    int count;
    void *values;
  } entry[HC_TALLY_MOST];
  int count;
} hc_tally;

/* What is to be reduced. Local. */
void hc_tally_sum_exact(hc_tally *tally, hc_sum *sums, int count);
void hc_tally_sum_i64(hc_tally *tally, int64_t *values, int count);
void hc_tally_max_i64(hc_tally *tally, int64_t *values, int count);
void hc_tally_max_f64(hc_tally *tally, double *values, int count);

/* Reduces all that was noted, and empties the tally. Collective: one reduction; none if it is empty. */
void hc_tally_reduce(hc_comm *comm, hc_tally *tally);

#endif
