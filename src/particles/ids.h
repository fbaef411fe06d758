/* Particle ids: 64 bits, kind in the top 4, source (block, wall, emitter) in the next 20, counter in the
 * last 40. */
#ifndef HC_IDS_H
#define HC_IDS_H

#include <stdint.h>

enum { HC_ID_SOURCE_BITS = 20, HC_ID_COUNTER_BITS = 40 };
#define HC_ID_MAX_SOURCES ((int64_t)1 << HC_ID_SOURCE_BITS)
#define HC_ID_MAX_COUNTER ((int64_t)1 << HC_ID_COUNTER_BITS)

/* Air and what is held are in the fluid's store only while rest states are fitted (simulation/rest.h). */
typedef enum hc_id_kind { HC_ID_FLUID = 0, HC_ID_BOUNDARY = 1, HC_ID_AIR = 2, HC_ID_HELD = 3 } hc_id_kind;

static inline uint64_t hc_id_make(hc_id_kind kind, uint64_t source, uint64_t counter) {
  return (uint64_t)kind << (HC_ID_SOURCE_BITS + HC_ID_COUNTER_BITS) | source << HC_ID_COUNTER_BITS | counter;
}

static inline int64_t hc_id_source_of(uint64_t id) {
  return (int64_t)(id >> HC_ID_COUNTER_BITS) & (HC_ID_MAX_SOURCES - 1);
}

static inline int64_t hc_id_counter_of(uint64_t id) {
  return (int64_t)(id & (uint64_t)(HC_ID_MAX_COUNTER - 1));
}

/* The same particle as of another kind. */
static inline uint64_t hc_id_as(uint64_t id, hc_id_kind kind) {
  return hc_id_make(kind, (uint64_t)hc_id_source_of(id), (uint64_t)hc_id_counter_of(id));
}

static inline hc_id_kind hc_id_kind_of(uint64_t id) {
  return (hc_id_kind)(id >> (HC_ID_SOURCE_BITS + HC_ID_COUNTER_BITS));
}

#endif
