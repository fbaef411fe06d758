#include "timings.h"

#include "atomic_file.h"
#include "text.h"

#include <inttypes.h>
#include <stdio.h>

static void put_number(FILE *stream, const char *name, double value) {
  char text[HC_TEXT_NUMBER];
  fprintf(stream, "  \"%s\": %s,\n", name, hc_text_json_number(text, value));
}

static void put_integer(FILE *stream, const char *name, int64_t value) {
  fprintf(stream, "  \"%s\": %" PRId64 ",\n", name, value);
}

static void put_spread(FILE *stream, const char *name, const hc_timings_spread *spread) {
  char text[3][HC_TEXT_NUMBER];
  hc_text_json_string(stream, name);
  fprintf(stream, ": {\"min\": %s, \"mean\": %s, \"max\": %s}", hc_text_json_number(text[0], spread->min),
          hc_text_json_number(text[1], spread->mean), hc_text_json_number(text[2], spread->max));
}

hc_status hc_timings_write(const hc_timings *timings, const char *directory, hc_error *error) {
  hc_atomic_file file;
  const hc_status status = hc_atomic_file_begin(&file, directory, "timings.json", error);
  if (status != HC_OK) return status;
  FILE *stream = file.stream;
  fprintf(stream, "{\n");
  put_integer(stream, "ranks", timings->ranks);
  put_integer(stream, "steps", timings->steps);
  put_integer(stream, "fluid_particles", timings->fluid_particles);
  put_integer(stream, "boundary_particles", timings->boundary_particles);
  put_number(stream, "simulated_seconds", timings->simulated_seconds);
  put_number(stream, "wall_seconds", timings->wall_seconds);
  put_number(stream, "particle_steps", timings->particle_steps);
  put_number(stream, "particle_steps_per_second", timings->particle_steps / timings->wall_seconds);
  put_number(stream, "ns_per_particle_step", 1e9 * timings->wall_seconds / timings->particle_steps);
  put_integer(stream, "halo_bytes", timings->halo_bytes);
  put_integer(stream, "messages", timings->messages);
  put_integer(stream, "sparse_exchanges", timings->sparse_exchanges);
  put_integer(stream, "reductions", timings->reductions);
  put_integer(stream, "other_collectives", timings->other_collectives);
  put_integer(stream, "gathered_bytes", timings->gathered_bytes);
  put_integer(stream, "rebalances", timings->rebalances);
  put_number(stream, "rebalance_seconds", timings->rebalance_seconds);
  put_integer(stream, "moved_particles", timings->moved_particles);
  put_number(stream, "imbalance", timings->imbalance);
  put_integer(stream, "rollbacks", timings->rollbacks);
  put_integer(stream, "rollback_steps", timings->rollback_steps);
  fprintf(stream, "  ");
  put_spread(stream, "ghosts_per_rank", &timings->ghosts);
  fprintf(stream, ",\n  ");
  put_spread(stream, "private_bytes_per_rank", &timings->private_bytes);
  fprintf(stream, ",\n  ");
  put_spread(stream, "memory_bytes_per_rank", &timings->memory_bytes);
  fprintf(stream, ",\n  \"seconds_per_rank\": {");
  for (int k = 0; k < timings->stage_count; k++) {
    fprintf(stream, "%s\n    ", k ? "," : "");
    put_spread(stream, timings->stages[k].name, &timings->stages[k].seconds);
  }
  fprintf(stream, "\n  }\n}\n");
  return hc_atomic_file_commit(&file, error);
}
