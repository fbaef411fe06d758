#include "rest_states.h"

#include "base/memory.h"
#include "setup/named_file.h"
#include "setup/solvers.h"
#include "setup/source.h"
#include "setup/world_frame.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const double SAME = 1e-6;       /* of lengths and densities that must be the same */
static const double DENSER = 0.002;    /* than the lattice a rest state may be, by number */
static const double COMPRESSED = 0.01; /* its densest particle, of the rest density */
static const double CALM = 0.05;       /* half spacings a step: what counts as at rest */
static const double FITS = 1e-3;       /* spacings by which a period may be off a multiple */

static bool has(const hc_scene *scene, bool later) {
  bool any = false;
  for (int k = 0; k < scene->fluid.block_count; k++) {
    const hc_block *const block = &scene->fluid.blocks[k];
    any |= block->rest_state[0] != '\0' && (block->start > 0.0) == later;
  }
  return any;
}

bool hc_setup_has_rest_states(const hc_scene *scene) {
  return has(scene, false);
}

bool hc_setup_has_refills(const hc_scene *scene) {
  return has(scene, true);
}

void hc_setup_free_start(hc_scene *scene) {
  const bool shapes_stay = scene->absorption_count > 0 || hc_scene_has_window(scene);
  if (!hc_setup_has_refills(scene) && !shapes_stay) hc_scene_free_surfaces(scene);
}

/* What rank 0 says of a file before its positions. */
typedef struct header {
  hc_error error;
  char file[HC_FILE_LENGTH];
  hc_rest_state state;
} header;

static bool differs(double a, double b) {
  return !(fabs(a - b) <= SAME * fabs(b));
}

/* A rest state must be of the scene's kind, and at rest. */
static hc_status check_kind(const hc_scene *scene, const header *h, hc_error *error) {
  const hc_rest_state *const s = &h->state;
  const struct {
    const char *what;
    double made, wanted;
  } same[] = {{"particle_spacing", s->particle_spacing, scene->particle_spacing},
              {"support_radius", s->support_radius, scene->support_radius},
              {"fluid.rest_density", s->rest_density, scene->fluid.rest_density},
              {"fluid.mass_factor", s->mass_factor, scene->fluid.mass_factor}};
  for (size_t k = 0; k < sizeof same / sizeof *same; k++)
    if (differs(same[k].made, same[k].wanted))
      return hc_error_set(error, HC_BAD_INPUT, "%s was made with a %s of %.9g, and the scene has %.9g",
                          h->file, same[k].what, same[k].made, same[k].wanted);
  const char *const solver = hc_setup_solver_ops(scene)->name;
  if (strcmp(s->solver, solver) != 0)
    return hc_error_set(error, HC_BAD_INPUT, "%s was made with the solver %s, and the scene has %s", h->file,
                        s->solver, solver);
  double volume = 1.0; /* spacings^3 */
  for (int a = 0; a < 3; a++) volume *= (double)s->extent[a] / HC_REST_PARTS;
  const double filled = (double)s->count / volume;
  if (filled > 1.0 + DENSER || s->density_max > 1.0 + COMPRESSED)
    return hc_error_set(
        error, HC_BAD_INPUT,
        "%s is denser than at rest: %.4f particles a spacing^3, at most %.4f of the rest density", h->file,
        filled, s->density_max);
  if (s->speed_max > CALM)
    return hc_error_set(
        error, HC_BAD_INPUT,
        "%s is not at rest: its fastest particle moved by %.3g half spacings in the last step", h->file,
        s->speed_max);
  return HC_OK;
}

/* Beyond an end there is nothing to fill with; around a period of the scene images must close. */
static hc_status check_extent(const hc_frame *frame, const hc_block *block, const header *h,
                              hc_error *error) {
  const hc_box box = hc_source_block_bounds(block);
  for (int a = 0; a < 3; a++) {
    const double spacing = (double)frame->spacing[a] * frame->unit[a],
                 extent = (double)h->state.extent[a] / HC_REST_PARTS * spacing,
                 period = (double)frame->period[a] * frame->unit[a];
    const double low = box.min[a] - block->rest_offset[a], high = box.max[a] - block->rest_offset[a];
    if (!h->state.periodic[a] && (low < -FITS * spacing || high > extent + FITS * spacing))
      return hc_error_set(
          error, HC_BAD_INPUT,
          "%s is not periodic along %c and reaches from %g to %g m there, the block from %g to %g m", h->file,
          "xyz"[a], block -> rest_offset[a], block -> rest_offset[a] + extent, box.min[a], box.max[a]);
    const double images = period / extent;
    if (period > 0.0 && high - low > period - frame->support_radius &&
        fabs(images - rint(images)) * extent > FITS * spacing)
      return hc_error_set(error, HC_BAD_INPUT,
                          "%s has a period of %.9g m along %c, of which the scene's, %.9g m, is no multiple",
                          h->file, extent, "xyz"[a], period);
  }
  return HC_OK;
}

static hc_status read_file(const hc_scene_files *files, const char *scene_name, const hc_block *block,
                           header *h, hc_rest_state **state) {
  hc_error *const error = &h->error;
  if (!files || !files->read_rest)
    return hc_error_set(error, HC_BAD_INPUT, "rest states cannot be read here");
  if (hc_named_file_find(scene_name, block->rest_state, h->file, error) != HC_OK ||
      files->read_rest(h->file, state, error) != HC_OK)
    return error->status;
  h->state = **state;
  char checksum[HC_CHECKSUM_LENGTH];
  snprintf(checksum, sizeof checksum, "%016" PRIx64, h->state.checksum);
  if (block->rest_checksum[0] && strcmp(block->rest_checksum, checksum) != 0)
    hc_error_set(
        error, HC_BAD_INPUT,
        "%s has the checksum %s, not %s: it has changed (leave rest_checksum away to take it as it is)",
        h->file, checksum, block->rest_checksum);
  return error->status;
}

/* Rank 0's on all ranks. */
static void send(hc_comm *comm, header *h, hc_rest_state **state) {
  hc_comm_broadcast(comm, h, sizeof *h, 0);
  if (h->error.status != HC_OK) return;
  const size_t bytes = (size_t)h->state.count * sizeof *h->state.position;
  if (comm->rank != 0) {
    *state = hc_alloc(1, sizeof **state);
    **state = h->state;
    (*state)->position = hc_alloc((size_t)h->state.count, sizeof *h->state.position);
  }
  hc_comm_broadcast(comm, (*state)->position, bytes, 0);
}

static void load(const hc_scene_files *files, const hc_scene *scene, const char *name, const hc_frame *frame,
                 int number, hc_findings *findings) {
  hc_block *const block = &scene->fluid.blocks[number];
  hc_comm *const comm = files ? files->comm : NULL;
  header *const h = hc_alloc_zero(1, sizeof *h);
  hc_rest_state *state = NULL;
  if (!comm || comm->rank == 0) read_file(files, name, block, h, &state);
  if (comm) send(comm, h, &state);
  hc_error *const error = &h->error;
  if (error->status == HC_OK && check_kind(scene, h, error) == HC_OK) check_extent(frame, block, h, error);
  if (error->status == HC_OK) {
    memcpy(block->rest_state, h->file, sizeof h->file);
    snprintf(block->rest_checksum, sizeof block->rest_checksum, "%016" PRIx64, h->state.checksum);
    block->rest = (hc_made_rest_state){state, hc_rest_state_free};
  } else {
    char path[64];
    snprintf(path, sizeof path, "fluid.blocks[%d].rest_state", number);
    hc_findings_error(findings, path, "%s: %s", hc_source_block_name(number).text, error->text);
    hc_rest_state_free(state);
  }
  hc_free(h);
}

void hc_setup_rest_states_load(const hc_scene_files *files, hc_scene *scene, const char *name,
                               hc_findings *findings) {
  hc_frame frame;
  hc_error error;
  if (!(hc_setup_has_rest_states(scene) || hc_setup_has_refills(scene))) return;
  if (hc_setup_frame(scene, &frame, &error) != HC_OK) return;
  for (int k = 0; k < scene->fluid.block_count; k++)
    if (scene->fluid.blocks[k].rest_state[0]) load(files, scene, name, &frame, k, findings);
}
