#include "h5.h"

#include "base/check.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

void hc_h5_silence(void) {
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
}

void hc_h5_close_alone(hid_t file, const hc_error *problem) {
  if (file >= 0) hc_check_give_up((int)problem->status, "%s", problem->text);
}

/* The two innermost entries say what happened ("file open failed", "errno = 2, ..."); the rest say only
 * through which functions it came. */
static herr_t collect(unsigned depth, const H5E_error2_t *entry, void *data) {
  char *text = data;
  if (depth >= 2 || !entry->desc || !*entry->desc) return 0;
  const size_t used = strlen(text);
  snprintf(text + used, 1024 - used, "%s%s", used ? "; " : "", entry->desc);
  return 0;
}

hc_status hc_h5_failed(hc_error *problem, hc_status status, const char *format, ...) {
  char reason[1024] = "", text[4096];
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, collect, reason);
  H5Eclear2(H5E_DEFAULT);
  if (problem->status != HC_OK) return problem->status;
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return hc_error_set(problem, status, "%s%s%s", text, *reason ? ": " : "", reason);
}

void hc_h5_put(hid_t where, const char *name, hid_t file_type, hid_t memory_type, int count,
               const void *values, hc_error *problem) {
  const hsize_t extent = (hsize_t)count;
  const hid_t space = count == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &extent, NULL);
  const hid_t attribute = H5Acreate2(where, name, file_type, space, H5P_DEFAULT, H5P_DEFAULT);
  if (attribute < 0 || H5Awrite(attribute, memory_type, values) < 0)
    hc_h5_failed(problem, HC_IO_FAILED, "cannot write attribute %s", name);
  if (attribute >= 0 && H5Aclose(attribute) < 0)
    hc_h5_failed(problem, HC_IO_FAILED, "cannot write attribute %s", name);
  if (space >= 0) H5Sclose(space);
}

void hc_h5_put_f64(hid_t where, const char *name, int count, const double *values, hc_error *problem) {
  hc_h5_put(where, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, count, values, problem);
}

void hc_h5_put_i64(hid_t where, const char *name, int count, const int64_t *values, hc_error *problem) {
  hc_h5_put(where, name, H5T_STD_I64LE, H5T_NATIVE_INT64, count, values, problem);
}

void hc_h5_put_text(hid_t where, const char *name, const char *text, hc_error *problem) {
  const size_t length = strlen(text);
  const hid_t type = H5Tcopy(H5T_C_S1);
  if (type < 0 || H5Tset_size(type, length ? length : 1) < 0 || H5Tset_strpad(type, H5T_STR_NULLPAD) < 0)
    hc_h5_failed(problem, HC_IO_FAILED, "cannot write attribute %s", name);
  hc_h5_put(where, name, type, type, 1, text, problem);
  if (type >= 0) H5Tclose(type);
}

void hc_h5_get(hid_t where, const char *name, hid_t memory_type, int count, void *values, hc_error *problem) {
  const hid_t attribute = H5Aopen(where, name, H5P_DEFAULT);
  const hid_t space = attribute < 0 ? attribute : H5Aget_space(attribute);
  const hssize_t found = space < 0 ? -1 : H5Sget_simple_extent_npoints(space);
  if (found < 0)
    hc_h5_failed(problem, HC_BAD_INPUT, "attribute %s is missing", name);
  else if (found != count)
    hc_h5_failed(problem, HC_BAD_INPUT, "attribute %s must have %d values, has %lld", name, count,
                 (long long)found);
  else if (H5Aread(attribute, memory_type, values) < 0)
    hc_h5_failed(problem, HC_BAD_INPUT, "cannot read attribute %s", name);
  if (space >= 0) H5Sclose(space);
  if (attribute >= 0) H5Aclose(attribute);
}

void hc_h5_get_text(hid_t where, const char *name, char *text, size_t size, hc_error *problem) {
  const hid_t type = H5Tcopy(H5T_C_S1);
  if (type < 0 || H5Tset_size(type, size) < 0)
    hc_h5_failed(problem, HC_BAD_INPUT, "cannot read attribute %s", name);
  else
    hc_h5_get(where, name, type, 1, text, problem);
  text[size - 1] = 0;
  if (type >= 0) H5Tclose(type);
}

hid_t hc_h5_create_group(hid_t where, const char *name, hc_error *problem) {
  const hid_t group = H5Gcreate2(where, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  if (group < 0) hc_h5_failed(problem, HC_IO_FAILED, "cannot create group %s", name);
  return group;
}

void hc_h5_close_group(hid_t group, hc_error *problem) {
  if (group >= 0 && H5Gclose(group) < 0) hc_h5_failed(problem, HC_IO_FAILED, "cannot close a group");
}

hid_t hc_h5_file_type(hc_field_type type) {
  switch (type) {
  case HC_TYPE_i64:
  case HC_TYPE_u64:
    return H5T_STD_I64LE;
  case HC_TYPE_f64:
    return H5T_IEEE_F64LE;
  case HC_TYPE_f32:
    return H5T_IEEE_F32LE;
  case HC_TYPE_record:
    break;
  }
  hc_check_failed(__FILE__, __LINE__, "a record cannot be written to a file");
}

hid_t hc_h5_memory_type(hc_field_type type) {
  switch (type) {
  case HC_TYPE_i64:
  case HC_TYPE_u64:
    return H5T_NATIVE_INT64;
  case HC_TYPE_f64:
    return H5T_NATIVE_DOUBLE;
  case HC_TYPE_f32:
    return H5T_NATIVE_FLOAT;
  case HC_TYPE_record:
    break;
  }
  hc_check_failed(__FILE__, __LINE__, "a record cannot be written to a file");
}
