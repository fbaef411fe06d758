#include "displace.h"

hc_status hc_simulation_displace(hc_simulation *simulation, hc_error *error) {
  simulation->displaced =
      hc_window_decide(&simulation->window, &simulation->world.frame, &simulation->bodies, error);
  if (simulation->displaced) hc_simulation_pose_walls(simulation);
  return error->status;
}

hc_status hc_simulation_renew(hc_simulation *simulation, hc_error *error) {
  if (!simulation->displaced) return HC_OK;
  hc_world *const world = &simulation->world;
  hc_scene_rest rules = simulation->scene->fluid.rest;
  hc_rest_fresh fresh = {.fitted = true};
  rules.target = simulation->scene->window.target;
  hc_window_renew(&simulation->window, world, &fresh.from, &fresh.to);
  hc_world_count_fluid(world);
  simulation->came = true;
  return hc_simulation_fit(simulation, &rules, &fresh, simulation->dt, error);
}
