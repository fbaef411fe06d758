/* Refreshes and folds over the partners that hc_halo_build has found. */
#include "base/bits.h"
#include "base/check.h"
#include "base/memory.h"
#include "halo.h"

#include <stddef.h>
#include <string.h>

/* A field, or the scalar of a record, as messages carry it. */
typedef struct column {
  char *data; /* of own particle 0 */
  size_t stride, bytes;
  bool place; /* moved by the periods */
} column;

enum { MOST_COLUMNS = 8 };

/* The columns of a set of fields; returns how many. */
static int find_columns(const hc_particles *particles, hc_field_set fields, column columns[MOST_COLUMNS]) {
  int count = 0;
  for (int bit = 0; bit < 64; bit++) {
    if (!(fields >> bit & 1)) continue;
    const int field = bit % 32;
    const hc_field_info *info = &hc_fields[field];
    HC_CHECK(field < HC_FIELD_COUNT && hc_field_has_ghosts(info, particles->features) &&
                 particles->data[field],
             "field %s has no ghosts here", field < HC_FIELD_COUNT ? info->name : "?");
    HC_CHECK(count < MOST_COLUMNS, "at most %d fields in one refresh", MOST_COLUMNS);
    column *to = &columns[count++];
    *to = (column){particles->data[field], info->bytes, info->bytes, false};
    if (bit < 32) {
      to->place = field == HC_FIELD_place;
    } else {
      HC_CHECK(info->type == HC_TYPE_record, "field %s is no record with a scalar", info->name);
      to->data += offsetof(hc_record, scalar);
      to->bytes = sizeof(float);
    }
  }
  return count;
}

size_t hc_halo_bytes(hc_field_set fields) {
  size_t bytes = 0;
  for (int bit = 0; bit < 64; bit++)
    if (fields >> bit & 1) bytes += bit < 32 ? hc_fields[bit].bytes : sizeof(float);
  return bytes;
}

/* Copies between a column's rows [begin, begin + count) and packed values. */
static char *pack_rows(char *to, const column *column, int32_t begin, int32_t count) {
  const char *from = column->data + column->stride * (size_t)begin;
  if (column->stride == column->bytes) {
    memcpy(to, from, column->bytes * (size_t)count);
  } else {
    for (int32_t k = 0; k < count; k++)
      memcpy(to + sizeof(float) * (size_t)k, from + column->stride * (size_t)k, sizeof(float));
  }
  return to + column->bytes * (size_t)count;
}

static const char *unpack_rows(const char *from, const column *column, int32_t begin, int32_t count) {
  char *to = column->data + column->stride * (size_t)begin;
  if (column->stride == column->bytes) {
    memcpy(to, from, column->bytes * (size_t)count);
  } else {
    for (int32_t k = 0; k < count; k++)
      memcpy(to + column->stride * (size_t)k, from + sizeof(float) * (size_t)k, sizeof(float));
  }
  return from + column->bytes * (size_t)count;
}

/* Moves `count` packed places by a shift. */
static void shift_places(char *places, int32_t count, const uint32_t shift[3]) {
  hc_record *records = (hc_record *)(void *)places;
  if (!(shift[0] | shift[1] | shift[2])) return;
  for (int32_t k = 0; k < count; k++)
    for (int axis = 0; axis < 3; axis++)
      records[k].x[axis] = (int32_t)((uint32_t)records[k].x[axis] + shift[axis]);
}

/* The own particles that a copy of a cell is made of. */
static void rows_of(const hc_halo *halo, const hc_halo_cell *cell, int32_t *begin, int32_t *count) {
  const int32_t brick = cell->slot / HC_BRICK_CELLS;
  *begin = halo->source->begin[brick][cell->slot % HC_BRICK_CELLS];
  *count = halo->source->count[brick][cell->slot % HC_BRICK_CELLS];
}

/* A column of a partner's message: all its cells. Records stay aligned, for they come first. */
static char *pack_column(const hc_halo *halo, int partner, const column *column, char *to) {
  for (int32_t k = halo->send_begin[partner]; k < halo->send_begin[partner + 1]; k++) {
    int32_t begin, count;
    uint32_t shift[3];
    rows_of(halo, &halo->cells[k], &begin, &count);
    char *cell = to;
    to = pack_rows(to, column, begin, count);
    hc_halo_shift(halo, &halo->cells[k], shift);
    if (column->place) shift_places(cell, count, shift);
  }
  return to;
}

/* The size of a message's bitmap. */
static size_t bitmap_bytes(int32_t count) {
  return ((size_t)count + 63) / 64 * sizeof(uint64_t);
}

/* The chosen rows of a partner's message, behind their bitmap: row by row. */
static char *pack_chosen(const hc_halo *halo, int partner, const column *columns, int column_count,
                         char *to) {
  uint64_t *bitmap = (uint64_t *)(void *)to;
  const int32_t copies = halo->copies[partner];
  memset(bitmap, 0, bitmap_bytes(copies));
  to += bitmap_bytes(copies);
  int32_t copy = 0;
  for (int32_t k = halo->send_begin[partner]; k < halo->send_begin[partner + 1]; k++) {
    int32_t begin, count;
    uint32_t shift[3];
    rows_of(halo, &halo->cells[k], &begin, &count);
    hc_halo_shift(halo, &halo->cells[k], shift);
    for (int32_t i = begin; i < begin + count; i++, copy++) {
      if (!hc_bits_have(halo->chosen, i)) continue;
      hc_bits_add(bitmap, copy);
      for (int c = 0; c < column_count; c++) {
        hc_record moved;
        if (columns[c].place) {
          pack_rows((char *)&moved, &columns[c], i, 1);
          shift_places((char *)&moved, 1, shift);
          memcpy(to, &moved, sizeof moved);
          to += sizeof moved;
        } else {
          to = pack_rows(to, &columns[c], i, 1);
        }
      }
    }
  }
  return to;
}

/* What is sent of a message that may have `most` bytes: its receiver expects as many parts as that has. */
static size_t bytes_to_send(const hc_halo *halo, size_t bytes, size_t most) {
  return most > hc_comm_part_limit(halo->domain->comm) ? most : bytes;
}

/* Room for messages of `bytes` each copy, and a bitmap for each partner, on both sides. */
static void make_buffers(hc_halo *halo, size_t bytes, bool bitmaps) {
  size_t out = 0, in = (size_t)halo->particles->ghosts * bytes;
  for (int partner = 0; partner < halo->send_count; partner++) {
    const int32_t copies = halo->copies[partner];
    out += (size_t)copies * bytes + (bitmaps ? bitmap_bytes(copies) + sizeof(uint64_t) : 0);
  }
  for (int m = 0; m < halo->receive_count && bitmaps; m++)
    in += bitmap_bytes(halo->ghost_begin[m + 1] - halo->ghost_begin[m]) + sizeof(uint64_t);
  hc_reserve((void **)&halo->send_buffer, &halo->send_capacity, out, 0, 1);
  hc_reserve((void **)&halo->receive_buffer, &halo->receive_capacity, in, 0, 1);
}

static size_t aligned(size_t bytes) {
  return (bytes + sizeof(uint64_t) - 1) / sizeof(uint64_t) * sizeof(uint64_t);
}

/* Where the messages come in: of `bytes` a ghost, at most. */
static void expect_messages(hc_halo *halo, size_t bytes, bool bitmaps) {
  char *to = halo->receive_buffer;
  for (int m = 0; m < halo->receive_count; m++) {
    const int32_t ghosts = halo->ghost_begin[m + 1] - halo->ghost_begin[m];
    halo->receive[m].data = to;
    halo->receive[m].bytes = (size_t)ghosts * bytes + (bitmaps ? bitmap_bytes(ghosts) : 0);
    to += bitmaps ? aligned(halo->receive[m].bytes) : halo->receive[m].bytes;
  }
}

static void start_exchange(hc_halo *halo, hc_field_set fields) {
  halo->exchange = (hc_exchange){
      halo->send_count, halo->receive_count, halo->send, halo->receive, halo->requests, NULL, 0};
  hc_comm_exchange_begin(halo->domain->comm, &halo->exchange, halo->tag);
  halo->fields = fields;
  halo->particles->under_way |= fields;
}

static void finish_exchange(hc_halo *halo) {
  hc_comm_exchange_end(halo->domain->comm, &halo->exchange);
  halo->particles->under_way &= ~halo->fields;
  halo->fields = 0;
}

void hc_halo_begin(hc_halo *halo, hc_field_set fields) {
  HC_CHECK(!halo->fields, "one refresh at a time");
  column columns[MOST_COLUMNS];
  const int count = find_columns(halo->particles, fields, columns);
  make_buffers(halo, hc_halo_bytes(fields), false);
  char *to = halo->send_buffer;
  for (int partner = 0; partner < halo->send_count; partner++) {
    halo->send[partner].data = to;
    for (int c = 0; c < count; c++) to = pack_column(halo, partner, &columns[c], to);
    halo->send[partner].bytes = (size_t)(to - (char *)halo->send[partner].data);
  }
  expect_messages(halo, hc_halo_bytes(fields), false);
  start_exchange(halo, fields);
}

void hc_halo_end(hc_halo *halo) {
  HC_CHECK(halo->fields && !halo->chosen, "no refresh is under way");
  column columns[MOST_COLUMNS];
  const int count = find_columns(halo->particles, halo->fields, columns);
  finish_exchange(halo);
  for (int m = 0; m < halo->receive_count; m++) {
    const char *from = halo->receive[m].data;
    const int32_t begin = halo->ghost_begin[m], ghosts = halo->ghost_begin[m + 1] - begin;
    for (int c = 0; c < count; c++)
      from = unpack_rows(from, &columns[c], halo->particles->own + begin, ghosts);
  }
}

void hc_halo_refresh(hc_halo *halo, hc_field_set fields) {
  hc_halo_begin(halo, fields);
  hc_halo_end(halo);
}

/* ---- of a selection ---- */

void hc_halo_begin_some(hc_halo *halo, hc_field_set fields, const uint64_t *chosen) {
  HC_CHECK(!halo->fields && chosen, "one refresh at a time, of a selection");
  column columns[MOST_COLUMNS];
  const int count = find_columns(halo->particles, fields, columns);
  make_buffers(halo, hc_halo_bytes(fields), true);
  halo->chosen = chosen;
  char *to = halo->send_buffer;
  for (int partner = 0; partner < halo->send_count; partner++) {
    halo->send[partner].data = to;
    const char *end = pack_chosen(halo, partner, columns, count, to);
    const size_t most =
        (size_t)halo->copies[partner] * hc_halo_bytes(fields) + bitmap_bytes(halo->copies[partner]);
    halo->send[partner].bytes = bytes_to_send(halo, (size_t)(end - to), most);
    to += aligned(halo->send[partner].bytes);
  }
  expect_messages(halo, hc_halo_bytes(fields), true);
  start_exchange(halo, fields);
}

void hc_halo_end_some(hc_halo *halo, uint64_t *selected) {
  HC_CHECK(halo->fields && halo->chosen, "no refresh of a selection is under way");
  column columns[MOST_COLUMNS];
  const int count = find_columns(halo->particles, halo->fields, columns);
  finish_exchange(halo);
  halo->chosen = NULL;
  if (selected) memset(selected, 0, bitmap_bytes(halo->particles->ghosts));
  for (int m = 0; m < halo->receive_count; m++) {
    const uint64_t *bitmap = halo->receive[m].data;
    const int32_t begin = halo->ghost_begin[m], ghosts = halo->ghost_begin[m + 1] - begin;
    const char *from = (const char *)halo->receive[m].data + bitmap_bytes(ghosts);
    for (int32_t k = 0; k < ghosts; k++) {
      if (!hc_bits_have(bitmap, k)) continue;
      if (selected) hc_bits_add(selected, begin + k);
      for (int c = 0; c < count; c++)
        from = unpack_rows(from, &columns[c], halo->particles->own + begin + k, 1);
    }
  }
}

/* ---- back to the owner ---- */

/* value = min(value, other), number by number; other may be unaligned. */
static void take_least(hc_field_type type, int components, void *value, const char *other) {
#define HC_LEAST(name)                                                                                       \
  case HC_TYPE_##name:                                                                                       \
    for (int k = 0; k < components; k++) {                                                                   \
      hc_field_##name mine, theirs;                                                                          \
      memcpy(&mine, (char *)value + (size_t)k * sizeof mine, sizeof mine);                                   \
      memcpy(&theirs, other + (size_t)k * sizeof theirs, sizeof theirs);                                     \
      if (theirs < mine) memcpy((char *)value + (size_t)k * sizeof mine, &theirs, sizeof theirs);            \
    }                                                                                                        \
    break
  switch (type) {
    HC_LEAST(i64);
    HC_LEAST(u64);
    HC_LEAST(f64);
    HC_LEAST(f32);
  case HC_TYPE_record:
    HC_CHECK(false, "a record has no least");
  }
#undef HC_LEAST
}

static size_t size_of(hc_field_type type) {
  static const size_t sizes[] = {
#define HC_SIZE(name) [HC_TYPE_##name] = sizeof(hc_field_##name)
      HC_SIZE(i64), HC_SIZE(u64), HC_SIZE(f64), HC_SIZE(f32), HC_SIZE(record)
#undef HC_SIZE
  };
  return sizes[type];
}

/* The rows from `begin` on that `chosen` names, behind their bitmap. */
static char *pack_back(const column *column, int32_t begin, int32_t count, const uint64_t *chosen, char *to) {
  uint64_t *bitmap = (uint64_t *)(void *)to;
  memset(bitmap, 0, bitmap_bytes(count));
  to += bitmap_bytes(count);
  for (int32_t k = 0; k < count; k++) {
    if (!hc_bits_have(chosen, begin + k)) continue;
    hc_bits_add(bitmap, k);
    to = pack_rows(to, column, begin + k, 1);
  }
  return to;
}

/* The messages of a refresh of a selection, the other way round. */
static void send_back(hc_halo *halo, const column *column, const uint64_t *chosen) {
  make_buffers(halo, column->bytes, true);
  expect_messages(halo, column->bytes, true);
  char *to = halo->send_buffer;
  for (int partner = 0; partner < halo->send_count; partner++) {
    const size_t most = (size_t)halo->copies[partner] * column->bytes + bitmap_bytes(halo->copies[partner]);
    halo->send[partner].data = to;
    halo->send[partner].bytes = most;
    to += aligned(most);
  }
  for (int m = 0; m < halo->receive_count; m++) {
    hc_message *const message = &halo->receive[m];
    char *const data = message->data, *const end = pack_back(
                                          column, halo->particles->own + halo->ghost_begin[m],
                                          halo->ghost_begin[m + 1] - halo->ghost_begin[m], chosen, data);
    message->bytes = bytes_to_send(halo, (size_t)(end - data), message->bytes);
  }
  halo->exchange = (hc_exchange){
      halo->receive_count, halo->send_count, halo->receive, halo->send, halo->requests, NULL, 0};
  hc_comm_exchange_begin(halo->domain->comm, &halo->exchange, halo->tag);
  hc_comm_exchange_end(halo->domain->comm, &halo->exchange);
}

void hc_halo_fold_least(hc_halo *halo, hc_field_type type, int components, void *values,
                        const uint64_t *chosen) {
  HC_CHECK(!halo->fields && chosen, "one exchange at a time, of a selection");
  HC_CHECK(type != HC_TYPE_record, "only plain numbers can be folded");
  const size_t bytes = (size_t)components * size_of(type);
  send_back(halo, &(column){values, bytes, bytes, false}, chosen);
  for (int partner = 0; partner < halo->send_count; partner++) {
    const uint64_t *const bitmap = halo->send[partner].data;
    const char *from = (const char *)halo->send[partner].data + bitmap_bytes(halo->copies[partner]);
    int32_t copy = 0;
    for (int32_t k = halo->send_begin[partner]; k < halo->send_begin[partner + 1]; k++) {
      int32_t begin, count;
      rows_of(halo, &halo->cells[k], &begin, &count);
      for (int32_t i = begin; i < begin + count; i++, copy++) {
        if (!hc_bits_have(bitmap, copy)) continue;
        take_least(type, components, (char *)values + bytes * (size_t)i, from);
        from += bytes;
      }
    }
  }
}
