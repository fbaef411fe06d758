/* HDF5 for this room: silence, errors as text, attributes. Included by no other room.
 *
 * Helpers take an hc_error that keeps the first failure ("problem"): once it is set they still run, because
 * other ranks run them too, but never overwrite it. */
#ifndef HC_H5_H
#define HC_H5_H

#include "halocline/error.h"
#include "particles/particles.h"

#include <hdf5.h>
#include <stddef.h>

/* Stops HDF5 from printing its error stack on stderr; its text is folded into ours. Local. */
void hc_h5_silence(void);

/* What HDF5 may want for itself while ranks write or read a file together, at the most: a rank that cannot
 * have it must say so before, or it leaves the others waiting. */
enum { HC_H5_MEMORY = 64 << 20 };

/* Some ranks have a shared file open and others could not open it: as closing is collective, the program ends
 * here with the status and text of `problem` if this rank has it. */
void hc_h5_close_alone(hid_t file, const hc_error *problem);

/* Puts a formatted message and HDF5's own reason into `problem` unless it already holds one; returns its
 * status. */
hc_status hc_h5_failed(hc_error *problem, hc_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Writes an attribute: a scalar for count 1, else a row. Collective over the ranks that share the file, with
 * the same values. Failure is HC_IO_FAILED. */
void hc_h5_put(hid_t where, const char *name, hid_t file_type, hid_t memory_type, int count,
               const void *values, hc_error *problem);
void hc_h5_put_f64(hid_t where, const char *name, int count, const double *values, hc_error *problem);
void hc_h5_put_i64(hid_t where, const char *name, int count, const int64_t *values, hc_error *problem);
void hc_h5_put_text(hid_t where, const char *name, const char *text,
                    hc_error *problem); /* fixed-length ASCII */

/* Reads an attribute of exactly `count` values (text: at most size - 1 bytes). Failure is HC_BAD_INPUT. */
void hc_h5_get(hid_t where, const char *name, hid_t memory_type, int count, void *values, hc_error *problem);
void hc_h5_get_text(hid_t where, const char *name, char *text, size_t size, hc_error *problem);

/* Groups. Collective over the ranks that share the file. Failure is HC_IO_FAILED; an invalid one is closed
 * for nothing. */
hid_t hc_h5_create_group(hid_t where, const char *name, hc_error *problem);
void hc_h5_close_group(hid_t group, hc_error *problem);

/* How a field's numbers are stored, and how they stand in memory. Ids are signed in files, as ParaView wants
 * them; the bits stay. */
hid_t hc_h5_file_type(hc_field_type type);
hid_t hc_h5_memory_type(hc_field_type type);

#endif
