/* The window goes along with its body: see window/window.h. */
#ifndef HC_DISPLACE_H
#define HC_DISPLACE_H

#include "simulation.h"

/* Behind the poses of a step: lets the window go along if it is due; simulation->displaced tells. Then
 * hc_simulation_renew must follow, behind hc_world_place. Local; HC_FAILED, the same on every rank. */
hc_status hc_simulation_displace(hc_simulation *simulation, hc_error *error);

/* Renews the water where the window has come to; simulation->came says that hc_world_place must follow.
 * Collective; HC_FAILED, agreed. */
hc_status hc_simulation_renew(hc_simulation *simulation, hc_error *error);

#endif
