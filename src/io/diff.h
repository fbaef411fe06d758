/* `halocline diff A B`: two snapshots or checkpoints, particle by particle, matched by id, whatever the ranks
 * that wrote them.
 *
 * Without a tolerance two files are the same if they hold the same ids, and for each id the same integer
 * position (relative to the scene's origin) and the same bits in every field that either has, at the same
 * step and time, and agree on spacing, support radius, periods, rest density, particle mass and gravity. The
 * tolerance T > 0 is absolute and one for all, in the unit of what it is held against: the time may differ by
 * T seconds, every component of a position by T metres, of a velocity by T m/s, of a pressure by T Pa; the
 * steps freely. NaN equals only the same NaN. Along periodic axes the shorter way round counts. If the files'
 * units of length differ, positions are compared in metres, as doubles. A different name of the scene is
 * reported, but no difference.
 *
 * The keys of the JSON object: same, tolerance; a and b: {file, scene, step, time, particles, pieces};
 * same_scene, same_step, same_time, same_unit; settings: a list of what the files do not agree on, {name,
 * unit, a, b}; common: particles in both files, differing: how many of them are not the same; only_in_a and
 * only_in_b: {count, ids}, the smallest ten; fields: a list of {name, unit, differing, and, if any differ,
 * worst (largest difference of a component, null for NaN), worst_units (a position's), id of that particle,
 * at (its position in A, m)}, or with trouble, why the field could not be compared. */
#ifndef HC_DIFF_H
#define HC_DIFF_H

#include "halocline/error.h"

#include <stdbool.h>
#include <stdio.h>

enum { HC_DIFF_SAME = 0, HC_DIFF_DIFFERENT = 1, HC_DIFF_IMPOSSIBLE = 2 };

typedef struct hc_diff_options {
  double tolerance; /* 0: bit for bit; see above */
  bool json;        /* one JSON object in place of the text */
} hc_diff_options;

/* Compares and reports to `out`. Local. Returns HC_DIFF_*: the program's exit code; with HC_DIFF_IMPOSSIBLE
 * the reason is in `error` and nothing was printed. */
int hc_diff_run(const char *a, const char *b, const hc_diff_options *options, FILE *out, hc_error *error);

#endif
