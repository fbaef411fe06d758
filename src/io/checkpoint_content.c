#include "checkpoint_content.h"

#include "base/check.h"
#include "base/memory.h"
#include "facts.h"

#include <stdio.h>
#include <string.h>

enum {
  HEADERS = 65536, /* room for all metadata besides the items' numbers */
  SLICE = 1 << 24  /* rows of one transfer: below the 2 GiB of one MPI call */
};

/* What a store is called: its group, and the attribute that counts its rows. */
typedef struct store_name {
  unsigned kind;
  const char *group, *count;
} store_name;

static const store_name *name_of(const hc_particles *store) {
  static const store_name names[] = {{HC_FLUID, "fluid", "fluid_particles"},
                                     {HC_BOUNDARY, "boundary", "standing_particles"},
                                     {HC_BOUNDARY | HC_MOVED, "moving", "moving_particles"},
                                     {HC_INFLOW, "inflow", "inflow_places"},
                                     {HC_WINDOW, "window", "window_places"}};
  const store_name *name = names;
  while (name->kind != store->kind) name++;
  return name;
}

static bool holds_particles(const hc_particles *store) {
  return !(store->kind & HC_PLACES);
}

/* The place of a store among those of the state. */
static int store_index(const hc_state *state, const hc_particles *store) {
  for (int k = 0; k < state->store_count; k++)
    if (state->stores[k] == store) return k;
  HC_CHECK(false, "the store is none of the state's");
  return -1;
}

void hc_checkpoint_content_count(hc_checkpoint_content *content) {
  const hc_state *state = content->state;
  for (int k = 0; k < state->store_count; k++) {
    content->first[k] = hc_comm_prefix_i64(content->comm, state->stores[k]->own);
    content->total[k] = state->stores[k]->own;
  }
  hc_comm_sum_i64(content->comm, content->total, state->store_count);
}

int64_t hc_checkpoint_content_bytes(const hc_checkpoint_content *content) {
  const hc_state *state = content->state;
  int64_t bytes = HEADERS + (int64_t)strlen(content->scene_text);
  for (int k = 0; k < state->item_count; k++) bytes += 512 + 8 * state->items[k].count;
  for (int k = 0; k < state->store_count; k++)
    bytes += content->total[k] *
             (int64_t)hc_particles_state_bytes(state->stores[k]->kind, state->stores[k]->features);
  return bytes;
}

/* ---- writing ---- */

typedef struct transfer {
  const hc_state *state;
  const int64_t *total, *first;
  hid_t group[HC_STATE_MOST_STORES]; /* by store, or the state's attributes in the first */
  hc_error *problem;
} transfer;

static void put_item(void *context, const hc_state_item *item) {
  const transfer *out = context;
  if (item->type == HC_TYPE_f64)
    hc_h5_put_f64(out->group[0], item->name, item->count, item->data, out->problem);
  else
    hc_h5_put_i64(out->group[0], item->name, item->count, item->data, out->problem);
}

/* Moves this rank's rows of a column, [first, first + count), in slices. Each rank for itself: its rows are
 * one piece of the file, so that HDF5's collective transfers have nothing to join, and took four times as
 * long where ranks share cores; and a rank that fails leaves nobody waiting. */
static void move_rows(hid_t dataset, const hc_field_info *info, int64_t first, int64_t count, char *rows,
                      bool write, hc_error *problem) {
  const hid_t type = hc_h5_memory_type(info->type);
  for (int64_t done = 0; done < count && problem->status == HC_OK; done += SLICE) {
    const int64_t some = count - done < SLICE ? count - done : SLICE;
    const hsize_t start[2] = {(hsize_t)(first + done), 0};
    const hsize_t extent[2] = {(hsize_t)some, (hsize_t)info->components};
    const hid_t file = H5Dget_space(dataset);
    const hid_t memory = H5Screate_simple(info->components > 1 ? 2 : 1, extent, NULL);
    char *at = rows + (size_t)done * info->bytes;
    const bool good = file >= 0 && memory >= 0 &&
                      H5Sselect_hyperslab(file, H5S_SELECT_SET, start, NULL, extent, NULL) >= 0 &&
                      (write ? H5Dwrite(dataset, type, memory, file, H5P_DEFAULT, at)
                             : H5Dread(dataset, type, memory, file, H5P_DEFAULT, at)) >= 0;
    if (!good)
      hc_h5_failed(problem, HC_IO_FAILED, "cannot %s %lld rows of %s", write ? "write" : "read",
                   (long long)some, info->name);
    if (memory >= 0) H5Sclose(memory);
    if (file >= 0) H5Sclose(file);
  }
}

static hid_t create_column(hid_t group, const hc_field_info *info, int64_t rows, hc_error *problem) {
  const hsize_t extent[2] = {(hsize_t)rows, (hsize_t)info->components};
  const hid_t space = H5Screate_simple(info->components > 1 ? 2 : 1, extent, NULL);
  const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
  hid_t dataset = H5I_INVALID_HID;
  /* Every row is written: no fill values. No time stamps: the bytes follow from the state. */
  if (space >= 0 && properties >= 0 && H5Pset_fill_time(properties, H5D_FILL_TIME_NEVER) >= 0 &&
      H5Pset_obj_track_times(properties, false) >= 0)
    dataset = H5Dcreate2(group, info->name, hc_h5_file_type(info->type), space, H5P_DEFAULT, properties,
                         H5P_DEFAULT);
  if (dataset < 0) hc_h5_failed(problem, HC_IO_FAILED, "cannot create dataset %s", info->name);
  if (properties >= 0) H5Pclose(properties);
  if (space >= 0) H5Sclose(space);
  return dataset;
}

static void put_field(void *context, hc_particles *particles, hc_field_id field) {
  const transfer *out = context;
  const int store = store_index(out->state, particles);
  const hc_field_info *info = &hc_fields[field];
  const hid_t dataset = create_column(out->group[store], info, out->total[store], out->problem);
  if (dataset < 0) return;
  move_rows(dataset, info, out->first[store], particles->own, particles->data[field], true, out->problem);
  if (H5Dclose(dataset) < 0) hc_h5_failed(out->problem, HC_IO_FAILED, "cannot close dataset %s", info->name);
}

static void put_scene(const hc_checkpoint_content *content, hid_t group, hc_error *problem) {
  const hsize_t length = strlen(content->scene_text);
  const hid_t space = H5Screate_simple(1, &length, NULL);
  const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
  const hid_t dataset =
      properties >= 0 && H5Pset_obj_track_times(properties, false) >= 0
          ? H5Dcreate2(group, "scene_text", H5T_STD_U8LE, space, H5P_DEFAULT, properties, H5P_DEFAULT)
          : H5I_INVALID_HID;
  if (dataset < 0 || (content->comm->rank == 0 && H5Dwrite(dataset, H5T_NATIVE_UINT8, H5S_ALL, H5S_ALL,
                                                           H5P_DEFAULT, content->scene_text) < 0))
    hc_h5_failed(problem, HC_IO_FAILED, "cannot write the scene");
  if (dataset >= 0) H5Dclose(dataset);
  if (properties >= 0) H5Pclose(properties);
  if (space >= 0) H5Sclose(space);
}

static void put_own(const hc_checkpoint_content *content, hid_t file, hc_error *problem) {
  const hid_t own = hc_h5_create_group(file, "Halocline", problem);
  const hc_state *state = content->state;
  const int64_t ranks = content->comm->size;
  int64_t fluid = 0, all = 0;
  for (int k = 0; k < state->store_count; k++) {
    if (holds_particles(state->stores[k])) all += content->total[k];
    if (state->stores[k]->kind == HC_FLUID) fluid = content->total[k];
  }
  int fields[HC_FIELD_COUNT], count = 0;
  hc_facts_put(own, content->scene, content->moment, fluid, all - fluid, problem);
  for (int k = 0; k < state->store_count; k++)
    if (state->stores[k]->kind != HC_FLUID)
      hc_h5_put_i64(own, name_of(state->stores[k])->count, 1, &content->total[k], problem);
  for (int field = 0; field < HC_FIELD_COUNT; field++) {
    bool there = false;
    for (int k = 0; k < state->store_count; k++) there |= state->stores[k]->data[field] != NULL;
    if (there && hc_field_is_state(&hc_fields[field])) fields[count++] = field;
  }
  hc_facts_put_fields(own, fields, count, problem);
  hc_h5_put_text(own, "content", "checkpoint", problem);
  hc_h5_put_text(own, "instruction_set", content->instruction_set, problem);
  hc_h5_put_i64(own, "ranks", 1, &ranks, problem);
  put_scene(content, own, problem);
  hc_h5_close_group(own, problem);
}

void hc_checkpoint_content_write(const hc_checkpoint_content *content, hid_t file, hc_error *problem) {
  const hc_state *state = content->state;
  put_own(content, file, problem);
  transfer out = {.state = state, .total = content->total, .first = content->first, .problem = problem};
  out.group[0] = hc_h5_create_group(file, "state", problem);
  hc_state_visit(state, 0, &(hc_state_visitor){.context = &out, .item = put_item});
  hc_h5_close_group(out.group[0], problem);
  for (int k = 0; k < state->store_count; k++)
    out.group[k] = hc_h5_create_group(file, name_of(state->stores[k])->group, problem);
  if (hc_comm_agree(content->comm, problem) == HC_OK)
    hc_state_visit(state, ~0u, &(hc_state_visitor){.context = &out, .field = put_field});
  for (int k = 0; k < state->store_count; k++) hc_h5_close_group(out.group[k], problem);
}

/* ---- reading ---- */

/* Opens the file on all ranks or on none. */
static hid_t open_shared(hc_comm *comm, const char *path, hc_error *problem) {
  hid_t file = H5I_INVALID_HID;
  if (!hc_memory_has(HC_H5_MEMORY)) hc_error_set(problem, HC_FAILED, "no memory to read it");
  if (hc_comm_agree(comm, problem) != HC_OK) return file;
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  hc_h5_silence();
  if (access >= 0 && H5Pset_fapl_mpio(access, comm->mpi, MPI_INFO_NULL) >= 0 &&
      H5Pset_all_coll_metadata_ops(access, true) >= 0) /* one rank reads what all must know */
    file = H5Fopen(path, H5F_ACC_RDONLY, access);
  if (file < 0) hc_h5_failed(problem, HC_IO_FAILED, "cannot be opened");
  if (access >= 0) H5Pclose(access);
  if (hc_comm_agree(comm, problem) != HC_OK) hc_h5_close_alone(file, problem);
  return problem->status == HC_OK ? file : H5I_INVALID_HID;
}

/* An error inside the file, from now on with its name. */
static hc_status name_file(hc_comm *comm, const char *path, const hc_error *problem, hc_error *error) {
  if (problem->status != HC_OK) {
    char reason[HC_ERROR_TEXT / 2];
    snprintf(reason, sizeof reason, "%.*s", (int)sizeof reason - 1, problem->text);
    hc_error_set(error, problem->status == HC_FAILED ? HC_FAILED : HC_IO_FAILED, "%s: %s", path, reason);
  }
  return hc_comm_agree(comm, error);
}

static void get_scene(hid_t group, char **text, hc_error *problem) {
  const hid_t dataset = H5Dopen2(group, "scene_text", H5P_DEFAULT);
  const hid_t space = dataset < 0 ? H5I_INVALID_HID : H5Dget_space(dataset);
  const hssize_t length = space < 0 ? -1 : H5Sget_simple_extent_npoints(space);
  *text = hc_alloc_zero(length > 0 ? (size_t)length + 1 : 1, 1);
  if (length < 0 || H5Dread(dataset, H5T_NATIVE_UINT8, H5S_ALL, H5S_ALL, H5P_DEFAULT, *text) < 0)
    hc_h5_failed(problem, HC_IO_FAILED, "cannot read the scene");
  if (space >= 0) H5Sclose(space);
  if (dataset >= 0) H5Dclose(dataset);
}

hc_status hc_checkpoint_facts_read(hc_comm *comm, const char *path, hc_checkpoint_facts *facts,
                                   hc_error *error) {
  hc_error problem = {.status = HC_OK};
  memset(facts, 0, sizeof *facts);
  const hid_t file = open_shared(comm, path, &problem);
  const hid_t own = file < 0 ? H5I_INVALID_HID : H5Gopen2(file, "Halocline", H5P_DEFAULT);
  if (file >= 0 && own < 0) hc_h5_failed(&problem, HC_IO_FAILED, "it has no group /Halocline");
  if (own >= 0) {
    hc_h5_get_text(own, "instruction_set", facts->instruction_set, sizeof facts->instruction_set, &problem);
    hc_h5_get(own, "ranks", H5T_NATIVE_INT64, 1, &facts->ranks, &problem);
    get_scene(own, &facts->scene_text, &problem);
    H5Gclose(own);
  }
  if (file >= 0) H5Fclose(file);
  if (name_file(comm, path, &problem, error) == HC_OK) return HC_OK;
  hc_free(facts->scene_text);
  facts->scene_text = NULL;
  return error->status;
}

static void get_item(void *context, const hc_state_item *item) {
  const transfer *in = context;
  hc_h5_get(in->group[0], item->name, hc_h5_memory_type(item->type), item->count, item->data, in->problem);
}

static void get_field(void *context, hc_particles *particles, hc_field_id field) {
  const transfer *in = context;
  const int store = store_index(in->state, particles);
  const hc_field_info *info = &hc_fields[field];
  const hid_t dataset = H5Dopen2(in->group[store], info->name, H5P_DEFAULT);
  if (dataset < 0) {
    hc_h5_failed(in->problem, HC_IO_FAILED, "dataset %s is missing", info->name);
    return;
  }
  move_rows(dataset, info, in->first[store], particles->own, particles->data[field], false, in->problem);
  H5Dclose(dataset);
}

/* Equal shares of the rows, for every rank. */
static hc_status share_rows(hc_comm *comm, const int64_t *total, hc_state *state, int64_t *first,
                            hc_error *problem) {
  for (int k = 0; k < state->store_count; k++) {
    const int64_t begin = total[k] * comm->rank / comm->size, end = total[k] * (comm->rank + 1) / comm->size;
    if (end - begin > INT32_MAX / 2)
      return hc_error_set(problem, HC_IO_FAILED, "%lld particles are too many for %d ranks",
                          (long long)total[k], comm->size);
    first[k] = begin;
    hc_particles_resize(state->stores[k], (int32_t)(end - begin));
  }
  return HC_OK;
}

static void read_all(hc_comm *comm, hid_t file, hc_state *state, hc_error *problem) {
  int64_t total[HC_STATE_MOST_STORES] = {0}, first[HC_STATE_MOST_STORES];
  transfer in = {.state = state, .total = total, .first = first, .problem = problem};
  const hid_t own = H5Gopen2(file, "Halocline", H5P_DEFAULT);
  for (int k = 0; k < state->store_count; k++)
    hc_h5_get(own, name_of(state->stores[k])->count, H5T_NATIVE_INT64, 1, &total[k], problem);
  if (own >= 0) H5Gclose(own);
  in.group[0] = H5Gopen2(file, "state", H5P_DEFAULT);
  hc_state_visit(state, 0, &(hc_state_visitor){.context = &in, .item = get_item});
  if (in.group[0] >= 0) H5Gclose(in.group[0]);
  if (problem->status == HC_OK && share_rows(comm, total, state, first, problem) == HC_OK) {
    for (int k = 0; k < state->store_count; k++)
      in.group[k] = H5Gopen2(file, name_of(state->stores[k])->group, H5P_DEFAULT);
    hc_state_visit(state, ~0u, &(hc_state_visitor){.context = &in, .field = get_field});
    for (int k = 0; k < state->store_count; k++)
      if (in.group[k] >= 0) H5Gclose(in.group[k]);
  }
}

hc_status hc_checkpoint_read(hc_comm *comm, const char *path, hc_state *state, hc_error *error) {
  hc_error problem = {.status = HC_OK};
  const hid_t file = open_shared(comm, path, &problem);
  if (file >= 0) read_all(comm, file, state, &problem);
  if (file >= 0) H5Fclose(file);
  H5garbage_collect();
  return name_file(comm, path, &problem, error);
}
