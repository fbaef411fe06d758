#include "memory.h"

#include "check.h"
#include "halocline/error.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#ifdef __GLIBC__
#  include <malloc.h>
#endif

/* From this size on memory is asked for in huge pages: neighbours of neighbours lie on many pages, and
 * looking up small ones costs a sweep over a million particles a quarter of its time. */
enum { HUGE_PAGE = 2 << 20 };

/* Room for `count` objects, of which `used` will be filled: whole huge pages only of these, because a huge
 * page is there as soon as a byte of it is touched. */
static void *allocate(size_t count, size_t used, size_t size) {
  HC_CHECK(size == 0 || count <= (SIZE_MAX / 2) / size, "allocation of %zu objects of %zu bytes", count,
           size);
  const size_t alignment = count * size >= 2 * HUGE_PAGE ? HUGE_PAGE : HC_ALIGNMENT;
  const size_t bytes = (count * size + alignment) / alignment * alignment;
  void *pointer = aligned_alloc(alignment, bytes);
  if (!pointer)
    hc_check_give_up(HC_FAILED, "out of memory: %zu bytes wanted, %zu in use", bytes, hc_memory_now());
  if (alignment == HUGE_PAGE) /* a hint: failure changes nothing */
    madvise(pointer, used * size / HUGE_PAGE * HUGE_PAGE, MADV_HUGEPAGE);
  return pointer;
}

void *hc_alloc(size_t count, size_t size) {
  return allocate(count, count, size);
}

void *hc_alloc_zero(size_t count, size_t size) {
  void *pointer = hc_alloc(count, size);
  memset(pointer, 0, count * size);
  return pointer;
}

void hc_free(void *pointer) {
  free(pointer);
}

void hc_reserve(void **pointer, size_t *capacity, size_t count, size_t keep, size_t size) {
  if (count <= *capacity && *pointer) return;
  const size_t roomy = count + count / 16 + 16;
  if (keep == 0) {
    hc_free(*pointer);
    *pointer = allocate(roomy, count, size);
  } else {
    void *grown = allocate(roomy, count, size);
    memcpy(grown, *pointer, keep * size);
    hc_free(*pointer);
    *pointer = grown;
  }
  *capacity = roomy;
}

size_t hc_memory_machine(void) {
  return (size_t)sysconf(_SC_PHYS_PAGES) * (size_t)sysconf(_SC_PAGESIZE);
}

size_t hc_memory_allowed(void) {
  struct rlimit limit;
  return getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY ? (size_t)limit.rlim_cur
                                                                              : SIZE_MAX;
}

bool hc_memory_has(size_t bytes) {
  void *volatile probe = malloc(bytes);
  free(probe);
  return probe != NULL;
}

void hc_memory_give_back(void) {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

/* Pages of this process: resident, and those of them that have a file or are shared. */
static bool read_pages(size_t *resident, size_t *shared) {
  FILE *file = fopen("/proc/self/statm", "r");
  if (!file) return false;
  const int read = fscanf(file, "%*u %zu %zu", resident, shared);
  fclose(file);
  return read == 2;
}

size_t hc_memory_now(void) {
  size_t resident, shared;
  return read_pages(&resident, &shared) ? resident * (size_t)sysconf(_SC_PAGESIZE) : 0;
}

size_t hc_memory_private(void) {
  size_t resident, shared;
  return read_pages(&resident, &shared) ? (resident - shared) * (size_t)sysconf(_SC_PAGESIZE) : 0;
}

size_t hc_memory_peak(void) {
  struct rusage usage;
  return getrusage(RUSAGE_SELF, &usage) == 0 ? (size_t)usage.ru_maxrss * 1024 : 0;
}
