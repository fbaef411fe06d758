#include "gaps.h"

#include "base/check.h"
#include "base/memory.h"

void hc_gaps_add(hc_gaps *gaps, int64_t k) {
  hc_gap *const last = gaps->count > 0 ? &gaps->gaps[gaps->count - 1] : NULL;
  HC_CHECK(!last || k >= last->end, "samples must be left out in ascending order, got %lld after %lld",
           (long long)k, (long long)(last ? last->end - 1 : -1));
  const int64_t before = hc_gaps_total(gaps);
  if (last && k == last->end) {
    last->end++;
    last->before_end++;
    return;
  }
  hc_reserve((void **)&gaps->gaps, &gaps->room, 2 * (size_t)gaps->count + 1, (size_t)gaps->count,
             sizeof *gaps->gaps);
  gaps->gaps[gaps->count++] = (hc_gap){k, k + 1, before + 1};
}

bool hc_gaps_hold(const hc_gaps *gaps, int64_t k) {
  int64_t low = 0, high = gaps->count;
  while (low < high) {
    const int64_t middle = low + (high - low) / 2;
    if (gaps->gaps[middle].end <= k)
      low = middle + 1;
    else
      high = middle;
  }
  return low < gaps->count && k >= gaps->gaps[low].start;
}

int64_t hc_gaps_total(const hc_gaps *gaps) {
  return gaps->count > 0 ? gaps->gaps[gaps->count - 1].before_end : 0;
}

int64_t hc_gaps_before(const hc_gaps *gaps, int64_t k) {
  int64_t low = 0, high = gaps->count; /* gaps below `low` end before the sample */
  while (low < high) {
    const int64_t middle = low + (high - low) / 2;
    if (gaps->gaps[middle].end <= k)
      low = middle + 1;
    else
      high = middle;
  }
  const int64_t before = low > 0 ? gaps->gaps[low - 1].before_end : 0;
  return low < gaps->count && gaps->gaps[low].start < k ? before + k - gaps->gaps[low].start : before;
}

int64_t hc_gaps_kept(const hc_gaps *gaps, int64_t place) {
  int64_t low = 0, high = gaps->count; /* gaps below `low` lie before the sample */
  while (low < high) {
    const int64_t middle = low + (high - low) / 2;
    const hc_gap *const gap = &gaps->gaps[middle];
    if (gap->end - gap->before_end <= place)
      low = middle + 1;
    else
      high = middle;
  }
  return place + (low > 0 ? gaps->gaps[low - 1].before_end : 0);
}

void hc_gaps_free(hc_gaps *gaps) {
  hc_free(gaps->gaps);
  *gaps = (hc_gaps){0};
}
