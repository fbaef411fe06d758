/* A surface sampled by all ranks together, once.
 *
 * Method: the ranks share out the places at which candidates may be (geometry/surface_layer.h), which is
 * where distances are asked for; one of them chooses among the candidates of all, and hands out the samples.
 */
#ifndef HC_DIVIDE_H
#define HC_DIVIDE_H

#include "comm/comm.h"
#include "geometry/surface_samples.h"

/* As hc_surface_samples_make, to the same bits on any number of ranks; each then holds its hc_setup_share of
 * the samples. `root`: who chooses. Collective. */
hc_status hc_divide_samples(hc_comm *comm, int root, hc_surface *surface, double spacing, int layers,
                            bool fluid_inside, hc_error *error);

#endif
