#include "timings.h"

#include "atomic_file.h"
#include "json.h"

static void put_spread(hc_json *json, const char *name, const hc_timings_spread *spread) {
  hc_json_object(json, name, HC_JSON_DENSE);
  hc_json_number(json, "min", spread->min);
  hc_json_number(json, "mean", spread->mean);
  hc_json_number(json, "max", spread->max);
  hc_json_end(json);
}

hc_status hc_timings_write(const hc_timings *timings, const char *directory, hc_error *error) {
  hc_atomic_file file;
  const hc_status status = hc_atomic_file_begin(&file, directory, "timings.json", error);
  if (status != HC_OK) return status;
  hc_json json;
  hc_json_begin(&json, file.stream, true);
  hc_json_object(&json, NULL, HC_JSON_LINES);
  hc_json_integer(&json, "ranks", timings->ranks);
  hc_json_integer(&json, "steps", timings->steps);
  hc_json_integer(&json, "fluid_particles", timings->fluid_particles);
  hc_json_integer(&json, "boundary_particles", timings->boundary_particles);
  hc_json_number(&json, "simulated_seconds", timings->simulated_seconds);
  hc_json_number(&json, "wall_seconds", timings->wall_seconds);
  hc_json_number(&json, "particle_steps", timings->particle_steps);
  hc_json_number(&json, "particle_steps_per_second", timings->particle_steps / timings->wall_seconds);
  hc_json_number(&json, "ns_per_particle_step", 1e9 * timings->wall_seconds / timings->particle_steps);
  hc_json_integer(&json, "halo_bytes", timings->halo_bytes);
  hc_json_integer(&json, "messages", timings->messages);
  hc_json_integer(&json, "sparse_exchanges", timings->sparse_exchanges);
  hc_json_integer(&json, "reductions", timings->reductions);
  hc_json_integer(&json, "other_collectives", timings->other_collectives);
  hc_json_integer(&json, "gathered_bytes", timings->gathered_bytes);
  hc_json_integer(&json, "rebalances", timings->rebalances);
  hc_json_number(&json, "rebalance_seconds", timings->rebalance_seconds);
  hc_json_integer(&json, "moved_particles", timings->moved_particles);
  hc_json_number(&json, "imbalance", timings->imbalance);
  hc_json_integer(&json, "rollbacks", timings->rollbacks);
  hc_json_integer(&json, "rollback_steps", timings->rollback_steps);
  put_spread(&json, "ghosts_per_rank", &timings->ghosts);
  put_spread(&json, "private_bytes_per_rank", &timings->private_bytes);
  put_spread(&json, "memory_bytes_per_rank", &timings->memory_bytes);
  hc_json_object(&json, "seconds_per_rank", HC_JSON_LINES);
  for (int k = 0; k < timings->stage_count; k++)
    put_spread(&json, timings->stages[k].name, &timings->stages[k].seconds);
  hc_json_end(&json);
  hc_json_end(&json);
  return hc_atomic_file_commit(&file, error);
}
