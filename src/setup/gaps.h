/* Which samples of a source are left out: ascending ranges, so that whole rows cost one entry. Local. */
#ifndef HC_GAPS_H
#define HC_GAPS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct hc_gap {
  int64_t start, end; /* [start, end) is left out */
  int64_t before_end; /* how many are left out below `end` */
} hc_gap;

/* Zeroed: nothing is left out. Freed with hc_gaps_free. */
typedef struct hc_gaps {
  hc_gap *gaps;
  int64_t count;
  size_t room;
} hc_gaps;

/* Leaves out sample k, which must be above all before. */
void hc_gaps_add(hc_gaps *gaps, int64_t k);

bool hc_gaps_hold(const hc_gaps *gaps, int64_t k);

/* How many are left out in all. */
int64_t hc_gaps_total(const hc_gaps *gaps);

/* How many are left out below sample k. */
int64_t hc_gaps_before(const hc_gaps *gaps, int64_t k);

/* The sample that is number `place` among those that are kept. */
int64_t hc_gaps_kept(const hc_gaps *gaps, int64_t place);

void hc_gaps_free(hc_gaps *gaps);

#endif
