/* What a look into a snapshot found, and how it is printed. Used by info.c only. */
#ifndef HC_INFO_REPORT_H
#define HC_INFO_REPORT_H

#include "snapshot_read.h"

#include <stdbool.h>
#include <stdio.h>

enum { HC_INFO_FLUID, HC_INFO_BOUNDARY, HC_INFO_KINDS };

typedef struct hc_info_range {
  double min, mean, max; /* min > max: no values */
  int64_t not_numbers;
} hc_info_range;

typedef struct hc_info_report {
  hc_snapshot_file file;
  int64_t piece_min, piece_max; /* particles */
  struct {
    int64_t count;
    double low[3], high[3]; /* m */
  } extent[HC_INFO_KINDS];
  hc_info_range fields[HC_SNAPSHOT_READ_FIELDS]; /* as file.fields */
  double mass, momentum[3];                      /* kg, kg m/s; NaN: not known */
  double kinetic_energy, potential_energy;       /* J */
} hc_info_report;

void hc_info_report_text(const hc_info_report *report, FILE *out);
void hc_info_report_json(const hc_info_report *report, FILE *out);

#endif
