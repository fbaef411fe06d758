/* What a comparison found, and how it is printed. Used by diff.c only. */
#ifndef HC_DIFF_REPORT_H
#define HC_DIFF_REPORT_H

#include "snapshot_read.h"

#include <stdint.h>
#include <stdio.h>

enum {
  HC_DIFF_LISTED = 10, /* missing ids that are named */
  HC_DIFF_SETTINGS = 6
};

/* One field, or the position. */
typedef struct hc_diff_field {
  const char *name, *unit;
  const char *trouble; /* why it could not be compared ("only in A"), or null */
  int64_t differing;   /* particles */
  double worst;        /* largest difference of a component, in `unit`; NaN if one side is not a number */
  int64_t worst_units; /* position: the same in units of length */
  uint64_t worst_id;
  double worst_at[3]; /* m, in A */
  bool found;         /* there is a worst */
} hc_diff_field;

/* A number of the scene (or three) that the files do not agree on. */
typedef struct hc_diff_setting {
  const char *name, *unit;
  int count;
  double a[3], b[3];
} hc_diff_setting;

typedef struct hc_diff_report {
  const hc_snapshot_file *a, *b;
  double tolerance;
  bool same, same_scene, same_time, same_step, same_unit;
  hc_diff_setting settings[HC_DIFF_SETTINGS]; /* that differ */
  int setting_count;
  int64_t common, differing;
  int64_t missing[2];                      /* ids only in A, only in B */
  uint64_t missing_ids[2][HC_DIFF_LISTED]; /* the smallest of them */
  hc_diff_field fields[2 * HC_SNAPSHOT_READ_FIELDS + 1];
  int field_count;
} hc_diff_report;

void hc_diff_report_text(const hc_diff_report *report, FILE *out);
void hc_diff_report_json(const hc_diff_report *report, FILE *out);

#endif
