#include "divide.h"

#include "base/memory.h"
#include "setup/share.h"

#include <string.h>

/* A layer's candidates, on `root`, in the order of their places. */
static hc_sample_candidates make_candidates(hc_comm *comm, int root, const hc_surface_layer *layer) {
  int64_t first, last;
  hc_setup_share(hc_surface_layer_places(layer), comm->rank, comm->size, &first, &last);
  hc_sample_candidates mine = hc_surface_layer_candidates(layer, first, last);
  if (comm->size == 1) return mine;
  void *all;
  size_t bytes;
  hc_comm_gather(comm, mine.at, (size_t)mine.count * sizeof *mine.at, root, &all, &bytes);
  hc_sample_candidates_free(&mine);
  const size_t count = bytes / sizeof *mine.at;
  return (hc_sample_candidates){.at = all, .count = (int32_t)count, .room = count};
}

/* What the root holds, in shares; the root last, for its own takes the place of all. */
static void hand_out(hc_comm *comm, int root, hc_surface *surface) {
  hc_comm_broadcast(comm, &surface->sample_count, sizeof surface->sample_count, root);
  hc_comm_broadcast(comm, surface->samples_low, sizeof surface->samples_low, root);
  hc_comm_broadcast(comm, surface->samples_high, sizeof surface->samples_high, root);
  const int count = comm->rank == root ? comm->size : 0;
  hc_message *const out = hc_alloc((size_t)count, sizeof *out), *in;
  for (int rank = 0; rank < count; rank++) {
    int64_t first, last;
    hc_setup_share(surface->sample_count, rank, comm->size, &first, &last);
    out[rank] =
        (hc_message){rank, (size_t)(last - first) * sizeof *surface->samples, surface->samples + first};
  }
  int received;
  hc_comm_sparse(comm, out, count, &in, &received);
  int64_t first, last;
  hc_setup_share(surface->sample_count, comm->rank, comm->size, &first, &last);
  hc_free(surface->samples);
  surface->samples = hc_alloc((size_t)(last - first), sizeof *surface->samples);
  surface->first_sample = first;
  surface->samples_held = last - first;
  if (received > 0) memcpy(surface->samples, in[0].data, in[0].bytes);
  hc_messages_free(in, received);
  hc_free(out);
}

hc_status hc_divide_samples(hc_comm *comm, int root, hc_surface *surface, double spacing, int layers,
                            bool fluid_inside, hc_error *error) {
  for (int number = 0; number < layers; number++) {
    hc_surface_layer layer = hc_surface_layer_make(surface, spacing, number, fluid_inside);
    const hc_status status = hc_surface_samples_check(&layer, error);
    if (status == HC_OK) {
      hc_sample_candidates candidates = make_candidates(comm, root, &layer);
      if (comm->rank == root) hc_surface_samples_choose(surface, &layer, &candidates);
      hc_sample_candidates_free(&candidates);
    }
    hc_surface_layer_free(&layer);
    if (status != HC_OK) return status;
  }
  hand_out(comm, root, surface);
  return HC_OK;
}
