/* Memory that is always there: an allocation that fails ends the program with what was asked for. */
#ifndef HC_MEMORY_H
#define HC_MEMORY_H

#include <stdbool.h>
#include <stddef.h>

enum { HC_ALIGNMENT = 64 };

/* `count` objects of `size` bytes, aligned to a cache line; contents undefined; `count` 0 gives a valid
 * pointer. Freed with hc_free. */
void *hc_alloc(size_t count, size_t size);
void *hc_alloc_zero(size_t count, size_t size);
void hc_free(void *pointer);

/* Gives `*pointer` room for at least `count` objects of `size` bytes, keeping the first `keep` of them.
 * `*capacity` counts objects. Grows by a sixteenth beyond what is asked, so that a slowly growing array is
 * seldom moved and never wastes much. */
void hc_reserve(void **pointer, size_t *capacity, size_t count, size_t keep, size_t size);

/* Bytes that this machine has for all its processes, and that this process may have at most (its limit on
 * address space, or SIZE_MAX). */
size_t hc_memory_machine(void);
size_t hc_memory_allowed(void);

/* Can this process have so many bytes more? They are asked for and given back. For work by libraries that do
 * not bear to run out, such as what HDF5 does on all ranks together: ask, agree, then begin. */
bool hc_memory_has(size_t bytes);

/* Gives memory that was freed back to the machine, which allocators put off. */
void hc_memory_give_back(void);

/* Resident memory of this process, in bytes: now, and at its highest. */
size_t hc_memory_now(void);
size_t hc_memory_peak(void);

/* Resident now and this process's alone: neither files, such as the program, nor memory shared between
 * processes, such as MPI's within a machine. */
size_t hc_memory_private(void);

#endif
