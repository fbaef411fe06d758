/* A rest state: a relaxed fluid in memory, whose images fill shapes (Carensac et al. 2023, section 3). Free
 * of any frame: in parts of its spacing. */
#ifndef HC_REST_STATE_H
#define HC_REST_STATE_H

#include <stdbool.h>
#include <stdint.h>

enum { HC_REST_PARTS = 1 << 20, HC_REST_NAME = 32 }; /* parts of a spacing */

typedef struct hc_rest_state {
  int32_t (*position)[3]; /* parts from the lower corner, in [0, extent) */
  int64_t count;
  int64_t extent[3];                                                  /* parts */
  bool periodic[3];                                                   /* else it ends there */
  double particle_spacing, support_radius, rest_density, mass_factor; /* it was made with: m, m, kg/m3, 1 */
  char solver[HC_REST_NAME];
  double density_mean, density_max, density_deviation; /* of the rest density */
  double speed_max;                                    /* half spacings a step, of the last step */
  int64_t steps;                                       /* damped ones that made it */
  uint64_t checksum;                                   /* of positions and extents */
} hc_rest_state;

void hc_rest_state_free(hc_rest_state *state); /* made with hc_alloc, positions too */

#endif
