/* Two ways to write a column:
 * - Floats and ids are contiguous in the file. Every rank writes its own slab by itself (independent
 * transfer): large, ordered, no exchange, converted in slices where a conversion is needed.
 * - Connectivity, offsets, cell types and kinds hold almost no information; shuffle + deflate makes them
 * nearly free. HDF5 wants compressed chunks written collectively, since a chunk may span two ranks. Known
 * weakness: a failing collective write can leave HDF5's ranks in different places, so snapshot.c reserves the
 * disk space and asks for memory first, and one that fails all the same ends the program. */
#include "snapshot_layout.h"

#include "base/check.h"
#include "base/memory.h"
#include "facts.h"
#include "particles/ids.h"

#include <stdio.h>
#include <string.h>

enum {
  SLICE = 8192,          /* particles converted at a time */
  PLAIN_SLICE = 1 << 24, /* rows of a direct write: below the 2 GiB of one MPI call */
  CHUNK = 65536,         /* rows of a compressed chunk */
  WINDOW = 2 * CHUNK,    /* rows of a compressed write */
  HEADERS = 65536,       /* room for all metadata */
  USUAL_HEADERS = 21776, /* what three fields take of it */
  FLUID = 0,
  BOUNDARY = 1
};

static void resolve_fields(hc_snapshot_layout *layout) {
  const hc_scene *scene = layout->scene;
  layout->fields[layout->field_count++] = HC_FIELD_id; /* always: it is what `diff` matches by */
  for (int k = 0; k < scene->output.snapshot_field_count; k++) {
    const char *name = scene->output.snapshot_fields[k];
    int field = 0;
    while (field < HC_FIELD_COUNT &&
           !((hc_fields[field].flags & HC_SNAPSHOT) && strcmp(hc_fields[field].name, name) == 0))
      field++;
    if (field == HC_FIELD_COUNT) {
      char known[512] = "";
      for (int f = 0; f < HC_FIELD_COUNT; f++) {
        if (!(hc_fields[f].flags & HC_SNAPSHOT)) continue;
        const size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", used ? ", " : "", hc_fields[f].name);
      }
      hc_error_set(layout->problem, HC_BAD_INPUT, "a snapshot has no field \"%s\"; there are: %s", name,
                   known);
      return;
    }
    bool seen = false;
    for (int other = 0; other < layout->field_count; other++) seen |= layout->fields[other] == field;
    if (!seen) layout->fields[layout->field_count++] = field;
  }
}

void hc_snapshot_layout_init(hc_snapshot_layout *layout, hc_comm *comm, const hc_scene *scene,
                             const hc_moment *moment, hc_error *problem) {
  memset(layout, 0, sizeof *layout);
  layout->comm = comm;
  layout->scene = scene;
  layout->moment = moment;
  layout->problem = problem;
  layout->file = layout->independent = layout->collective = H5I_INVALID_HID;
  const int64_t mine[2] = {moment->fluid->own,
                           moment->boundary->own + (moment->moving ? moment->moving->own : 0)};
  void *all = NULL;
  size_t bytes = 0;
  hc_comm_gather_all(comm, mine, sizeof mine, &all, &bytes);
  HC_CHECK(bytes == (size_t)comm->size * sizeof mine, "%zu bytes of counts from %d ranks", bytes, comm->size);
  layout->counts = all;
  for (int rank = 0; rank < comm->size; rank++) {
    layout->fluid += layout->counts[rank][FLUID];
    layout->boundary += layout->counts[rank][BOUNDARY];
  }
  resolve_fields(layout);
}

void hc_snapshot_layout_free(hc_snapshot_layout *layout) {
  hc_free(layout->counts);
}

/* Of a particle in the columns that are not packed: its point and fields. */
static int64_t plain_bytes(const hc_snapshot_layout *layout) {
  int64_t particle = 3 * 8;
  for (int k = 0; k < layout->field_count; k++) particle += (int64_t)hc_fields[layout->fields[k]].bytes;
  return particle;
}

int64_t hc_snapshot_layout_estimate(const hc_scene *scene, int64_t particles, hc_error *problem) {
  hc_snapshot_layout layout = {.scene = scene, .problem = problem};
  resolve_fields(&layout);
  return particles * plain_bytes(&layout) + particles * 15 / 100 + USUAL_HEADERS;
}

int64_t hc_snapshot_layout_bytes(const hc_snapshot_layout *layout) {
  const int64_t total = layout->fluid + layout->boundary;
  const int64_t particle = plain_bytes(layout) + 8 + 8 + 1 + 1; /* connectivity, offsets, types, kind */
  /* One more chunk of each compressed column: the last one is stored whole. */
  const int64_t chunk = total < CHUNK ? total : CHUNK;
  return total * particle + (int64_t)layout->comm->size * 5 * 8 + chunk * (8 + 8 + 1 + 1) + HEADERS;
}

/* ---- definition ---- */

static void define(hc_snapshot_layout *layout, hc_snapshot_column *column, hid_t group, const char *name,
                   hid_t type, int components, bool packed) {
  const hsize_t extent[2] = {(hsize_t)column->rows, (hsize_t)components};
  const hsize_t chunk[1] = {column->rows < CHUNK ? (hsize_t)column->rows : CHUNK};
  const hid_t space = H5Screate_simple(components > 1 ? 2 : 1, extent, NULL);
  const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
  /* Every row is written below: no fill values. No time stamps: the bytes follow from the state. */
  bool good = space >= 0 && properties >= 0 && H5Pset_fill_time(properties, H5D_FILL_TIME_NEVER) >= 0 &&
              H5Pset_obj_track_times(properties, false) >= 0;
  if (good && packed && column->rows > 0)
    good = H5Pset_chunk(properties, 1, chunk) >= 0 && H5Pset_shuffle(properties) >= 0 &&
           H5Pset_deflate(properties, 1) >= 0;
  column->dataset =
      good ? H5Dcreate2(group, name, type, space, H5P_DEFAULT, properties, H5P_DEFAULT) : H5I_INVALID_HID;
  if (column->dataset < 0) hc_h5_failed(layout->problem, HC_IO_FAILED, "cannot create dataset %s", name);
  if (properties >= 0) H5Pclose(properties);
  if (space >= 0) H5Sclose(space);
}

static void define_vtk(hc_snapshot_layout *layout) {
  const int64_t version[2] = {1, 0};
  const hid_t vtk = hc_h5_create_group(layout->file, "VTKHDF", layout->problem);
  hc_h5_put_i64(vtk, "Version", 2, version, layout->problem);
  hc_h5_put_text(vtk, "Type", "UnstructuredGrid", layout->problem);
  static const char *const per_piece[3] = {"NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"};
  for (int k = 0; k < 3; k++)
    define(layout, &layout->per_piece[k], vtk, per_piece[k], H5T_STD_I64LE, 1, false);
  define(layout, &layout->points, vtk, "Points", H5T_IEEE_F64LE, 3, false);
  define(layout, &layout->connectivity, vtk, "Connectivity", H5T_STD_I64LE, 1, true);
  define(layout, &layout->offsets, vtk, "Offsets", H5T_STD_I64LE, 1, true);
  define(layout, &layout->types, vtk, "Types", H5T_STD_U8LE, 1, true);
  const hid_t data = hc_h5_create_group(vtk, "PointData", layout->problem);
  define(layout, &layout->kind, data, "kind", H5T_STD_U8LE, 1, true);
  for (int k = 0; k < layout->field_count; k++) {
    const hc_field_info *info = &hc_fields[layout->fields[k]];
    define(layout, &layout->field[k], data, info->name, hc_h5_file_type(info->type), info->components, false);
  }
  hc_h5_close_group(data, layout->problem);
  hc_h5_close_group(vtk, layout->problem);
}

static void define_own(hc_snapshot_layout *layout) {
  const hid_t own = hc_h5_create_group(layout->file, "Halocline", layout->problem);
  hc_facts_put(own, layout->scene, layout->moment, layout->fluid, layout->boundary, layout->problem);
  define(layout, &layout->per_piece[3], own, "fluid_per_piece", H5T_STD_I64LE, 1, false);
  hc_facts_put_fields(own, layout->fields, layout->field_count, layout->problem);
  hc_h5_close_group(own, layout->problem);
}

void hc_snapshot_layout_define(hc_snapshot_layout *layout) {
  const int ranks = layout->comm->size, me = layout->comm->rank;
  int64_t first = 0;
  for (int rank = 0; rank < me; rank++) first += layout->counts[rank][FLUID] + layout->counts[rank][BOUNDARY];
  const int64_t total = layout->fluid + layout->boundary;
  const int64_t mine = layout->counts[me][FLUID] + layout->counts[me][BOUNDARY];
  const hc_snapshot_column particles = {H5I_INVALID_HID, -1, first, mine, total};
  layout->points = layout->connectivity = layout->types = layout->kind = particles;
  layout->offsets = (hc_snapshot_column){H5I_INVALID_HID, -1, first + me, mine + 1, total + ranks};
  for (int k = 0; k < layout->field_count; k++) {
    layout->field[k] = particles;
    layout->field[k].field = layout->fields[k];
  }
  for (int k = 0; k < 4; k++)
    layout->per_piece[k] = (hc_snapshot_column){H5I_INVALID_HID, -1, 0, me == 0 ? ranks : 0, ranks};

  layout->independent = H5Pcreate(H5P_DATASET_XFER);
  layout->collective = H5Pcreate(H5P_DATASET_XFER);
  if (layout->independent < 0 || layout->collective < 0 ||
      H5Pset_dxpl_mpio(layout->independent, H5FD_MPIO_INDEPENDENT) < 0 ||
      H5Pset_dxpl_mpio(layout->collective, H5FD_MPIO_COLLECTIVE) < 0)
    hc_h5_failed(layout->problem, HC_IO_FAILED, "cannot set up parallel transfers");
  define_vtk(layout);
  define_own(layout);
}

/* ---- data ---- */

typedef struct range {
  int64_t first, count; /* rows */
} range;

/* Writes two ranges of rows, which lie one behind the other in memory; either may be empty, but a collective
 * transfer is called all the same. */
static void write_ranges(hc_snapshot_layout *layout, const hc_snapshot_column *column, hid_t transfer,
                         hid_t type, int components, const range ranges[2], const void *rows) {
  const int64_t total = ranges[0].count + ranges[1].count;
  const hsize_t extent[2] = {(hsize_t)total, (hsize_t)components};
  const hid_t file = H5Dget_space(column->dataset);
  const hid_t memory = H5Screate_simple(components > 1 ? 2 : 1, extent, NULL);
  bool good = file >= 0 && memory >= 0 && H5Sselect_none(file) >= 0;
  if (good && total == 0) good = H5Sselect_none(memory) >= 0;
  for (int k = 0; k < 2; k++) {
    if (!good || ranges[k].count == 0) continue;
    const hsize_t start[2] = {(hsize_t)ranges[k].first, 0};
    const hsize_t count[2] = {(hsize_t)ranges[k].count, (hsize_t)components};
    good = H5Sselect_hyperslab(file, H5S_SELECT_OR, start, NULL, count, NULL) >= 0;
  }
  if (!good || H5Dwrite(column->dataset, type, memory, file, transfer, rows) < 0) {
    hc_h5_failed(layout->problem, HC_IO_FAILED, "cannot write %lld rows", (long long)total);
    /* The others may wait for this rank within HDF5, and would for ever. */
    if (transfer == layout->collective && layout->comm->size > 1)
      hc_check_give_up(HC_IO_FAILED, "snapshot: %s", layout->problem->text);
  }
  if (memory >= 0) H5Sclose(memory);
  if (file >= 0) H5Sclose(file);
}

static void write_rows(hc_snapshot_layout *layout, const hc_snapshot_column *column, hid_t type,
                       int components, int64_t first, int64_t count, const void *rows) {
  const range ranges[2] = {{first, count}, {0, 0}};
  write_ranges(layout, column, layout->independent, type, components, ranges, rows);
}

/* The stores in the order of their rows; returns how many. */
static int list_stores(const hc_snapshot_layout *layout, const hc_particles *stores[3]) {
  stores[0] = layout->moment->fluid;
  stores[1] = layout->moment->boundary;
  stores[2] = layout->moment->moving;
  return stores[2] ? 3 : 2;
}

static void fill_points(hc_snapshot_layout *layout, double *slice) {
  const hc_frame *frame = layout->moment->frame;
  const hc_particles *stores[3];
  const int store_count = list_stores(layout, stores);
  int64_t row = layout->points.first;
  for (int store = 0; store < store_count; store++) {
    const hc_particles *particles = stores[store];
    for (int64_t done = 0; done < particles->own; done += SLICE) {
      const int64_t left = particles->own - done, count = left < SLICE ? left : SLICE;
      const int64_t *position = particles->position + 3 * done;
      for (int64_t k = 0; k < 3 * count; k++) slice[k] = hc_frame_to_metres(frame, (int)(k % 3), position[k]);
      write_rows(layout, &layout->points, H5T_NATIVE_DOUBLE, 3, row, count, slice);
      row += count;
    }
  }
}

static void fill_field(hc_snapshot_layout *layout, const hc_snapshot_column *column, void *slice) {
  const hc_field_info *info = &hc_fields[column->field];
  HC_CHECK(info->bytes <= 3 * sizeof(double), "field %s has %zu bytes, a slice has room for %zu", info->name,
           info->bytes, 3 * sizeof(double));
  const hc_particles *stores[3];
  const int store_count = list_stores(layout, stores);
  int64_t row = column->first;
  for (int store = 0; store < store_count; store++) {
    const hc_particles *particles = stores[store];
    const bool has = particles->data[column->field] != NULL;
    const int64_t step = has ? PLAIN_SLICE : SLICE;
    if (!has) memset(slice, 0, SLICE * info->bytes);
    for (int64_t done = 0; done < particles->own; done += step) {
      const int64_t left = particles->own - done, count = left < step ? left : step;
      const void *rows =
          has ? (const char *)particles->data[column->field] + (size_t)done * info->bytes : slice;
      write_rows(layout, column, hc_h5_memory_type(info->type), info->components, row, count, rows);
      row += count;
    }
  }
}

/* Values of a compressed column for particles [first, first + count) of this rank. */
typedef void produce(const hc_snapshot_layout *layout, int64_t first, int64_t count, void *values);

/* Connectivity and offsets both count up from 0 within the piece. */
static void produce_count(const hc_snapshot_layout *layout, int64_t first, int64_t count, void *values) {
  (void)layout;
  for (int64_t k = 0; k < count; k++) ((int64_t *)values)[k] = first + k;
}

static void produce_types(const hc_snapshot_layout *layout, int64_t first, int64_t count, void *values) {
  enum { VERTEX = 1 };
  (void)layout, (void)first;
  memset(values, VERTEX, (size_t)count);
}

/* Fluid, walls, bodies. */
static void produce_kinds(const hc_snapshot_layout *layout, int64_t first, int64_t count, void *values) {
  enum { BODY = 2 };
  const hc_particles *const moving = layout->moment->moving;
  const int64_t fluid = layout->moment->fluid->own, walls = fluid + layout->moment->boundary->own;
  for (int64_t k = first; k < first + count; k++) {
    const bool body =
        k >= walls && hc_scene_is_body(layout->scene, (int)hc_id_source_of(moving->id[k - walls]));
    ((uint8_t *)values)[k - first] = k < fluid ? HC_ID_FLUID : body ? BODY : HC_ID_BOUNDARY;
  }
}

/* Writes a compressed column, a window of whole chunks at a time to bound the memory. The chunks that this
 * rank may share with others, its first and its last, come at the end in one call, so that each is packed
 * once, by one rank, from everybody's rows. Collective; afterwards `problem` is agreed. */
static hc_status fill_packed(hc_snapshot_layout *layout, const hc_snapshot_column *column, size_t bytes,
                             produce *values) {
  const hid_t type = bytes == 1 ? H5T_NATIVE_UINT8 : H5T_NATIVE_INT64;
  const int64_t first = column->first, end = first + column->count;
  const int64_t up = (first + CHUNK - 1) / CHUNK * CHUNK, down = end / CHUNK * CHUNK;
  const int64_t inner = up < end ? up : end, inner_end = down > inner ? down : inner;
  int64_t rounds = (inner_end - inner + WINDOW - 1) / WINDOW;
  hc_comm_max_i64(layout->comm, &rounds, 1);
  char *scratch = hc_alloc(rounds ? WINDOW : 2 * CHUNK, bytes);
  for (int64_t round = 0; round < rounds; round++) {
    const int64_t start = inner + round * WINDOW, left = inner_end - start;
    const int64_t count = left <= 0 ? 0 : left < WINDOW ? left : WINDOW;
    const range ranges[2] = {{start, count}, {0, 0}};
    values(layout, start - first, count, scratch);
    write_ranges(layout, column, layout->collective, type, 1, ranges, scratch);
  }
  const range borders[2] = {{first, inner - first}, {inner_end, end - inner_end}};
  values(layout, 0, borders[0].count, scratch);
  values(layout, inner_end - first, borders[1].count, scratch + (size_t)borders[0].count * bytes);
  write_ranges(layout, column, layout->collective, type, 1, borders, scratch);
  hc_free(scratch);
  return hc_comm_agree(layout->comm, layout->problem);
}

static void fill_per_piece(hc_snapshot_layout *layout) {
  if (layout->comm->rank != 0) return;
  const size_t ranks = (size_t)layout->comm->size;
  int64_t *numbers = hc_alloc(ranks, sizeof *numbers);
  for (int k = 0; k < 4; k++) {
    for (size_t rank = 0; rank < ranks; rank++)
      numbers[rank] = layout->counts[rank][FLUID] + (k == 3 ? 0 : layout->counts[rank][BOUNDARY]);
    write_rows(layout, &layout->per_piece[k], H5T_NATIVE_INT64, 1, 0, (int64_t)ranks, numbers);
  }
  hc_free(numbers);
}

void hc_snapshot_layout_fill(hc_snapshot_layout *layout) {
  double *slice = hc_alloc(3 * SLICE, sizeof *slice);
  fill_per_piece(layout);
  fill_points(layout, slice);
  for (int k = 0; k < layout->field_count; k++) fill_field(layout, &layout->field[k], slice);
  hc_free(slice);
  if (hc_comm_agree(layout->comm, layout->problem) != HC_OK) return;
  if (fill_packed(layout, &layout->offsets, sizeof(int64_t), produce_count) != HC_OK) return;
  if (layout->fluid + layout->boundary == 0) return; /* the rest are empty, and empty ones have no chunks */
  if (fill_packed(layout, &layout->connectivity, sizeof(int64_t), produce_count) != HC_OK) return;
  if (fill_packed(layout, &layout->types, 1, produce_types) != HC_OK) return;
  fill_packed(layout, &layout->kind, 1, produce_kinds);
}

void hc_snapshot_layout_close(hc_snapshot_layout *layout) {
  hc_snapshot_column *const single[] = {&layout->points, &layout->connectivity, &layout->offsets,
                                        &layout->types, &layout->kind};
  hc_snapshot_column *all[5 + 4 + HC_SNAPSHOT_MAX_FIELDS];
  int count = 0;
  for (int k = 0; k < 5; k++) all[count++] = single[k];
  for (int k = 0; k < 4; k++) all[count++] = &layout->per_piece[k];
  for (int k = 0; k < layout->field_count; k++) all[count++] = &layout->field[k];
  for (int k = 0; k < count; k++)
    if (all[k]->dataset >= 0 && H5Dclose(all[k]->dataset) < 0)
      hc_h5_failed(layout->problem, HC_IO_FAILED, "cannot close a dataset");
  if (layout->independent >= 0) H5Pclose(layout->independent);
  if (layout->collective >= 0) H5Pclose(layout->collective);
}
