/* How much of a line is wet. Particles within a spacing of it form runs, with gaps of up to 1.5 spacings; a
 * run ends where the fluid does: where the kernel's sum over the particles around has fallen to half of its
 * largest in the run, at most half a spacing beyond the last particle. So a flat surface is half a spacing
 * above its particles, and a rough one at its mean, as a wire or a photograph has it. */
#ifndef HC_HEIGHTS_H
#define HC_HEIGHTS_H

#include "measures.h"

/* A particle near a gauge's line. */
typedef struct hc_mark {
  int64_t gauge;
  double along, beside; /* m */
} hc_mark;

typedef struct hc_marks {
  hc_mark *at;
  size_t count, room;
} hc_marks;

/* Adds own particles within a support radius of gauge g's line. Local. */
void hc_heights_mark(const hc_gauges *gauges, int g, const hc_particles *fluid, hc_marks *marks);

/* Everybody's marks, on every rank, in an order that does not depend on the ranks. Collective. */
void hc_heights_gather(hc_comm *comm, hc_marks *marks);

/* The wet length of gauge g's line, m, from all marks. Local. */
double hc_heights_wet(const hc_gauges *gauges, int g, const hc_marks *marks);

#endif
