#include "rest_file.h"

#include "base/memory.h"
#include "h5.h"
#include "halocline/version.h"
#include "json.h"
#include "scene/writer.h"
#include "seal.h"
#include "shared_file.h"

#include <math.h>
#include <string.h>
#include <xxhash.h>

enum { FORMAT = 1, MOST = 1 << 28 /* particles */, MOST_SPACINGS = 2047 };
static const char content[] = "rest state";

/* ---- writing ---- */

/* A dataset that rank 0 fills. */
static void put_data(hid_t group, const char *name, hid_t file_type, hid_t memory_type, int rank,
                     const hsize_t *extent, const void *data, bool mine, hc_error *problem) {
  const hid_t space = H5Screate_simple(rank, extent, NULL), properties = H5Pcreate(H5P_DATASET_CREATE);
  hid_t dataset = H5I_INVALID_HID;
  if (space >= 0 && properties >= 0 && H5Pset_obj_track_times(properties, false) >= 0)
    dataset = H5Dcreate2(group, name, file_type, space, H5P_DEFAULT, properties, H5P_DEFAULT);
  if (dataset < 0 || (mine && H5Dwrite(dataset, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0))
    hc_h5_failed(problem, HC_IO_FAILED, "cannot write %s", name);
  if (dataset >= 0) H5Dclose(dataset);
  if (properties >= 0) H5Pclose(properties);
  if (space >= 0) H5Sclose(space);
}

static void put_facts(hid_t group, const hc_scene *scene, const hc_rest_state *state, hc_error *problem) {
  const int64_t format = FORMAT;
  int64_t periodic[3];
  double extent[3];
  for (int a = 0; a < 3; a++) {
    periodic[a] = state->periodic[a];
    extent[a] = (double)state->extent[a] / HC_REST_PARTS * state->particle_spacing;
  }
  hc_h5_put_text(group, "content", content, problem);
  hc_h5_put_i64(group, "rest_format", 1, &format, problem);
  hc_h5_put_text(group, "program_version", hc_version(), problem);
  hc_h5_put_text(group, "scene", scene->name, problem);
  hc_h5_put_text(group, "solver", state->solver, problem);
  hc_h5_put_f64(group, "particle_spacing", 1, &state->particle_spacing, problem);
  hc_h5_put_f64(group, "support_radius", 1, &state->support_radius, problem);
  hc_h5_put_f64(group, "rest_density", 1, &state->rest_density, problem);
  hc_h5_put_f64(group, "mass_factor", 1, &state->mass_factor, problem);
  hc_h5_put_f64(group, "extent", 3, extent, problem);
  hc_h5_put_i64(group, "periodic", 3, periodic, problem);
  hc_h5_put_i64(group, "particles", 1, &state->count, problem);
  hc_h5_put_i64(group, "steps", 1, &state->steps, problem);
  hc_h5_put_f64(group, "density_mean", 1, &state->density_mean, problem);
  hc_h5_put_f64(group, "density_max", 1, &state->density_max, problem);
  hc_h5_put_f64(group, "density_deviation", 1, &state->density_deviation, problem);
  hc_h5_put_f64(group, "speed_max", 1, &state->speed_max, problem);
}

static void put_all(hc_comm *comm, hid_t file, const hc_scene *scene, const char *scene_text,
                    const hc_rest_state *state, hc_error *problem) {
  const hid_t group = hc_h5_create_group(file, "Halocline", problem);
  const hsize_t length = strlen(scene_text), rows[2] = {(hsize_t)state->count, 3};
  put_facts(group, scene, state, problem);
  put_data(group, "scene_text", H5T_STD_U8LE, H5T_NATIVE_UINT8, 1, &length, scene_text, comm->rank == 0,
           problem);
  put_data(group, "position", H5T_STD_I32LE, H5T_NATIVE_INT32, 2, rows, state->position, comm->rank == 0,
           problem);
  hc_h5_close_group(group, problem);
}

hc_status hc_rest_file_write(hc_comm *comm, const hc_scene *scene, const char *path,
                             const hc_rest_state *state, hc_error *error) {
  hc_error problem = {.status = HC_OK};
  hc_rest_state facts = *state; /* all ranks write the same attributes */
  hc_comm_broadcast(comm, &facts, sizeof facts, 0);
  facts.position = state->position;
  char folder[HC_TEXT_PATH] = ".";
  const char *const slash = strrchr(path, '/');
  if (slash) hc_text_path(folder, &problem, "%.*s", slash == path ? 1 : (int)(slash - path), path);
  char *const scene_text = hc_scene_text(scene);
  hc_shared_file file;
  char seal[HC_SEAL_BYTES];
  const int64_t bytes =
      (1 << 16) + (int64_t)strlen(scene_text) + facts.count * (int64_t)sizeof *facts.position;
  if (hc_shared_file_open(&file, comm, folder, ".", slash ? slash + 1 : path, bytes, HC_SEAL_BYTES,
                          &problem) == HC_OK) {
    put_all(comm, file.handle, scene, scene_text, &facts, &problem);
    if (hc_shared_file_close(&file) == HC_OK && hc_seal_make(comm, file.temporary, seal, &problem) == HC_OK)
      hc_shared_file_seal(&file, seal, sizeof seal);
  }
  hc_shared_file_end(&file);
  hc_free(scene_text);
  if (problem.status != HC_OK) *error = problem;
  return problem.status;
}

/* ---- reading ---- */

static void get_positions(hid_t group, hc_rest_state *state, hc_error *problem) {
  const hid_t dataset = H5Dopen2(group, "position", H5P_DEFAULT);
  const hid_t space = dataset < 0 ? H5I_INVALID_HID : H5Dget_space(dataset);
  hsize_t extent[2] = {0, 0};
  if (space < 0 || H5Sget_simple_extent_ndims(space) != 2 ||
      H5Sget_simple_extent_dims(space, extent, NULL) != 2 || extent[0] != (hsize_t)state->count ||
      extent[1] != 3)
    hc_h5_failed(problem, HC_BAD_INPUT, "its positions are not as many as it says");
  if (problem->status == HC_OK) {
    state->position = hc_alloc((size_t)state->count, sizeof *state->position);
    if (H5Dread(dataset, H5T_NATIVE_INT32, H5S_ALL, H5S_ALL, H5P_DEFAULT, state->position) < 0)
      hc_h5_failed(problem, HC_BAD_INPUT, "its positions cannot be read");
  }
  if (space >= 0) H5Sclose(space);
  if (dataset >= 0) H5Dclose(dataset);
}

static bool is_length(double x) {
  return isfinite(x) && x > 0.0;
}

/* What has no place in a whole file, whoever made it. */
static void check(const hc_rest_state *state, const double extent[3], hc_error *problem) {
  if (problem->status != HC_OK) return;
  bool good = is_length(state->particle_spacing) && is_length(state->support_radius) &&
              is_length(state->rest_density) && is_length(state->mass_factor) && state->count > 0 &&
              state->count <= MOST && state->density_max >= 0.0 && state->speed_max >= 0.0;
  for (int a = 0; a < 3 && good; a++) {
    const double spacings = extent[a] / state->particle_spacing;
    good = spacings * state->particle_spacing >= 2.0 * state->support_radius && spacings <= MOST_SPACINGS;
  }
  if (!good)
    hc_error_set(
        problem, HC_BAD_INPUT,
        "its numbers make no sense: extents must be from two support radii to %d spacings, particles from 1 "
        "to 2^28",
        MOST_SPACINGS);
}

static void check_positions(const hc_rest_state *state, hc_error *problem) {
  for (int64_t k = 0; k < state->count && problem->status == HC_OK; k++)
    for (int a = 0; a < 3; a++)
      if (state->position[k][a] < 0 || state->position[k][a] >= state->extent[a]) {
        hc_error_set(problem, HC_BAD_INPUT, "its particle %lld lies beyond its extent", (long long)k);
        break;
      }
}

static void get_all(hid_t group, hc_rest_state *state, hc_error *problem) {
  char text[HC_REST_NAME] = "";
  int64_t format = 0, periodic[3] = {0, 0, 0};
  double extent[3] = {0.0, 0.0, 0.0};
  hc_h5_get_text(group, "content", text, sizeof text, problem);
  if (problem->status == HC_OK && strcmp(text, content) != 0)
    hc_error_set(problem, HC_BAD_INPUT, "it holds a %s, not a rest state", text);
  hc_h5_get(group, "rest_format", H5T_NATIVE_INT64, 1, &format, problem);
  if (problem->status == HC_OK && format != FORMAT)
    hc_error_set(problem, HC_BAD_INPUT, "it has format %lld, and this program reads %d", (long long)format,
                 FORMAT);
  hc_h5_get_text(group, "solver", state->solver, sizeof state->solver, problem);
  hc_h5_get(group, "particle_spacing", H5T_NATIVE_DOUBLE, 1, &state->particle_spacing, problem);
  hc_h5_get(group, "support_radius", H5T_NATIVE_DOUBLE, 1, &state->support_radius, problem);
  hc_h5_get(group, "rest_density", H5T_NATIVE_DOUBLE, 1, &state->rest_density, problem);
  hc_h5_get(group, "mass_factor", H5T_NATIVE_DOUBLE, 1, &state->mass_factor, problem);
  hc_h5_get(group, "extent", H5T_NATIVE_DOUBLE, 3, extent, problem);
  hc_h5_get(group, "periodic", H5T_NATIVE_INT64, 3, periodic, problem);
  hc_h5_get(group, "particles", H5T_NATIVE_INT64, 1, &state->count, problem);
  hc_h5_get(group, "steps", H5T_NATIVE_INT64, 1, &state->steps, problem);
  hc_h5_get(group, "density_mean", H5T_NATIVE_DOUBLE, 1, &state->density_mean, problem);
  hc_h5_get(group, "density_max", H5T_NATIVE_DOUBLE, 1, &state->density_max, problem);
  hc_h5_get(group, "density_deviation", H5T_NATIVE_DOUBLE, 1, &state->density_deviation, problem);
  hc_h5_get(group, "speed_max", H5T_NATIVE_DOUBLE, 1, &state->speed_max, problem);
  check(state, extent, problem);
  if (problem->status != HC_OK) return;
  for (int a = 0; a < 3; a++) {
    state->periodic[a] = periodic[a] != 0;
    state->extent[a] = llrint(extent[a] / state->particle_spacing * HC_REST_PARTS);
  }
  get_positions(group, state, problem);
  check_positions(state, problem);
}

hc_status hc_rest_file_read(const char *path, hc_rest_state **state, hc_error *error) {
  hc_error problem = {.status = HC_OK};
  hc_rest_state *const made = hc_alloc_zero(1, sizeof *made);
  hc_h5_silence();
  *state = NULL;
  if (!hc_seal_is_there(path)) {
    FILE *const there = fopen(path, "rb");
    if (there) fclose(there);
    hc_error_set(&problem, HC_BAD_INPUT, there ? "not a rest state" : "cannot be opened");
  } else {
    hc_seal_check(NULL, path, &problem);
  }
  const hid_t file = problem.status == HC_OK ? H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT) : H5I_INVALID_HID;
  const hid_t group = file < 0 ? H5I_INVALID_HID : H5Gopen2(file, "Halocline", H5P_DEFAULT);
  if (group >= 0)
    get_all(group, made, &problem);
  else
    hc_h5_failed(&problem, HC_BAD_INPUT, "it has no group /Halocline");
  if (group >= 0) H5Gclose(group);
  if (file >= 0) H5Fclose(file);
  if (problem.status != HC_OK) {
    hc_rest_state_free(made);
    const bool named = strstr(problem.text, path) != NULL;
    return hc_error_set(error, HC_BAD_INPUT, "%s%s%.4000s", named ? "" : path, named ? "" : ": ",
                        problem.text);
  }
  made->checksum = XXH3_64bits_withSeed(made->position, (size_t)made->count * sizeof *made->position,
                                        (XXH64_hash_t)made->extent[0] ^ (XXH64_hash_t)made->extent[1] << 20 ^
                                            (XXH64_hash_t)made->extent[2] << 40);
  *state = made;
  return HC_OK;
}

/* ---- telling ---- */

bool hc_rest_file_is(const char *path) {
  if (!hc_seal_is_there(path)) return false;
  hc_error problem = {.status = HC_OK};
  char text[HC_REST_NAME] = "";
  if (hc_seal_check(NULL, path, &problem) != HC_OK) return false; /* who reads it tells */
  const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t group = file < 0 ? H5I_INVALID_HID : H5Gopen2(file, "Halocline", H5P_DEFAULT);
  if (group >= 0) {
    hc_h5_get_text(group, "content", text, sizeof text, &problem);
    H5Gclose(group);
  }
  if (file >= 0) H5Fclose(file);
  return strcmp(text, content) == 0;
}

static void print_json(const char *path, const hc_rest_state *s, const double extent[3], FILE *out) {
  const double periodic[3] = {s->periodic[0], s->periodic[1], s->periodic[2]};
  hc_json json;
  hc_json_begin(&json, out, true);
  hc_json_object(&json, NULL, HC_JSON_LINES);
  hc_json_string(&json, "file", path);
  hc_json_string(&json, "content", content);
  hc_json_string(&json, "solver", s->solver);
  hc_json_number(&json, "particle_spacing", s->particle_spacing);
  hc_json_number(&json, "support_radius", s->support_radius);
  hc_json_number(&json, "rest_density", s->rest_density);
  hc_json_number(&json, "mass_factor", s->mass_factor);
  hc_json_numbers(&json, "extent", 3, extent);
  hc_json_numbers(&json, "periodic", 3, periodic);
  hc_json_integer(&json, "particles", s->count);
  hc_json_integer(&json, "steps", s->steps);
  hc_json_number(&json, "density_mean", s->density_mean);
  hc_json_number(&json, "density_max", s->density_max);
  hc_json_number(&json, "density_deviation", s->density_deviation);
  hc_json_number(&json, "speed_max", s->speed_max);
  hc_json_end(&json);
}

static void print_text(const char *path, const hc_rest_state *s, const double extent[3], FILE *out) {
  fprintf(out, "%s: a rest state\n", path);
  fprintf(out, "made with           %s, particle spacing %g m, support radius %g m, rest density %g kg/m3\n",
          s->solver, s->particle_spacing, s->support_radius, s->rest_density);
  fprintf(out, "particles           %lld in %g x %g x %g m, periodic along", (long long)s->count, extent[0],
          extent[1], extent[2]);
  bool any = false;
  for (int a = 0; a < 3; a++) {
    if (s->periodic[a]) fprintf(out, " %c", "xyz"[a]);
    any |= s->periodic[a];
  }
  fprintf(out, "%s\n", any ? "" : " no axis");
  fprintf(out, "density             mean %.5f, most %.5f, deviation %.5f of the rest density\n",
          s->density_mean, s->density_max, s->density_deviation);
  fprintf(out, "at rest             after %lld damped steps, the fastest at %.3g half spacings a step\n",
          (long long)s->steps, s->speed_max);
}

hc_status hc_rest_file_print(const char *path, bool json, FILE *out, hc_error *error) {
  hc_rest_state *state;
  if (hc_rest_file_read(path, &state, error) != HC_OK) return error->status;
  double extent[3];
  for (int a = 0; a < 3; a++) extent[a] = (double)state->extent[a] / HC_REST_PARTS * state->particle_spacing;
  (json ? print_json : print_text)(path, state, extent, out);
  hc_rest_state_free(state);
  return HC_OK;
}
