/* `halocline diff A B`: two snapshots, particle by particle, matched by id, whatever the ranks that wrote
 * them.
 *
 * Without a tolerance two files are the same if they hold the same ids, and for each id the same integer
 * position (relative to the scene's origin) and the same bits in every field that either has, at the same
 * step and time. With tolerance T > 0 a particle is the same if every component of its position differs by at
 * most T metres and every component of each field by at most T times the largest magnitude of that field in
 * either file; NaN equals only the same NaN. The times may then differ by T relative, the steps freely. Along
 * periodic axes the shorter way round counts. If the files' units of length differ, positions are compared in
 * metres, as doubles. */
#ifndef HC_DIFF_H
#define HC_DIFF_H

#include "halocline/error.h"

#include <stdbool.h>
#include <stdio.h>

enum { HC_DIFF_SAME = 0, HC_DIFF_DIFFERENT = 1, HC_DIFF_IMPOSSIBLE = 2 };

typedef struct hc_diff_options {
  double tolerance; /* 0: bit for bit */
  bool json;        /* one JSON object in place of the text */
} hc_diff_options;

/* Compares and reports to `out`. Local. Returns HC_DIFF_*: the program's exit code; with HC_DIFF_IMPOSSIBLE
 * the reason is in `error` and nothing was printed. */
int hc_diff_run(const char *a, const char *b, const hc_diff_options *options, FILE *out, hc_error *error);

#endif
