/* The inner loops of the neighbour search, compiled once per instruction set.
 *
 * The test for the support radius is made on integers: positions cut to 2^-12 of a cell edge, 16 bits each,
 * whose wrapped differences are exact up to eight cells. So it depends on no frame and no rounding, and a
 * multiply-add of pairs of 16-bit numbers squares two differences at once. The radius is widened by what the
 * cut may hide (and along axes with a stretched cell edge by the stretch): the list may hold a few neighbours
 * just beyond the support radius, where the kernel is exactly zero, and never misses one.
 *
 * Stores of compressed hits go through a register: the compressing store to memory is microcoded on some
 * processors. */
#include "neighbors.h"

#include "base/simd.h"

#if HC_HAS_AVX2 && !HC_HAS_AVX512
/* Byte k of entry m: the place of the k-th set bit of m. */
#  define HC_BIT(m, b) ((uint64_t)((m) >> (b)&1))
#  define HC_BITS_BELOW(m, b) (8 * __builtin_popcount((m) & ((1 << (b)) - 1)))
#  define HC_PLACE(m, b) ((HC_BIT(m, b) * (b)) << HC_BITS_BELOW(m, b))
#  define HC_PLACES(m)                                                                                       \
    (HC_PLACE(m, 1) | HC_PLACE(m, 2) | HC_PLACE(m, 3) | HC_PLACE(m, 4) | HC_PLACE(m, 5) | HC_PLACE(m, 6) |   \
     HC_PLACE(m, 7))
#  define HC_FOUR(m) HC_PLACES(m), HC_PLACES((m) + 1), HC_PLACES((m) + 2), HC_PLACES((m) + 3)
#  define HC_SIXTEEN(m) HC_FOUR(m), HC_FOUR((m) + 4), HC_FOUR((m) + 8), HC_FOUR((m) + 12)
#  define HC_SIXTY_FOUR(m) HC_SIXTEEN(m), HC_SIXTEEN((m) + 16), HC_SIXTEEN((m) + 32), HC_SIXTEEN((m) + 48)
static const uint64_t hc_compress_places[256] = {HC_SIXTY_FOUR(0), HC_SIXTY_FOUR(64), HC_SIXTY_FOUR(128),
                                                 HC_SIXTY_FOUR(192)};
#endif

/* A distance of one cell edge is HC_CUT_EDGE; each of two cut positions may hide less than 1, so a component
 * less than 1 and a distance less than sqrt(3). */
static inline int32_t near_of(const hc_neighbor_search *search) {
  return (search->reach + 2) * (search->reach + 2);
}

/* x and y in one word, z in another. */
HC_INLINE int32_t cut_xy(const hc_record *place) {
  return (int32_t)((uint32_t)place->x[0] >> 16 | ((uint32_t)place->x[1] & 0xffff0000u));
}
HC_INLINE int32_t cut_z(const hc_record *place) {
  return (int32_t)((uint32_t)place->x[2] >> 16);
}

/* Reads up to HC_LANES - 1 records beyond the last: the store has them (particles.h). */
static void append(hc_neighbor_search *search, int32_t end, const hc_record *place, int32_t begin,
                   int32_t count) {
  int32_t *restrict xy = search->xy + end, *restrict z = search->z + end;
  uint32_t *restrict offset = search->offset + end;
  for (int32_t k = 0; k < count; k += HC_LANES) {
    uint32_t lanes[HC_LANES];
    const hc_unsigned offsets =
        ((hc_unsigned)hc_lane_numbers() + (uint32_t)(begin + k)) * (uint32_t)sizeof(hc_record);
    memcpy(lanes, &offsets, sizeof lanes);
    hc_int column[4];
    hc_load_records(place, lanes, column);
    const hc_int low = hc_set_int(0xffff);
    const hc_int cut = (column[0] >> 16 & low) | (column[1] & ~low), cut_z = column[2] >> 16 & low;
    memcpy(xy + k, &cut, sizeof cut);
    memcpy(z + k, &cut_z, sizeof cut_z);
    memcpy(offset + k, &offsets, sizeof offsets);
  }
}

/* Writes the offsets of candidates [begin, end) near `self`, `self_offset` excepted, to `out`; returns how
 * many. Reads and writes up to sixteen entries further. */
HC_INLINE int32_t filter(const int32_t *restrict all_xy, const int32_t *restrict all_z,
                         const uint32_t *restrict all_offsets, int32_t count, const hc_record *self,
                         uint32_t self_offset, int32_t most, uint32_t *restrict out) {
  uint32_t *next = out;
#if HC_HAS_AVX512
  const __m512i own_xy = _mm512_set1_epi32(cut_xy(self)), own_z = _mm512_set1_epi32(cut_z(self)),
                own_offset = _mm512_set1_epi32((int)self_offset), near = _mm512_set1_epi32(most);
  for (int32_t k = 0; k < count; k += 16) {
    const __m512i offset = _mm512_loadu_si512(all_offsets + k);
    const __m512i xy = _mm512_sub_epi16(own_xy, _mm512_loadu_si512(all_xy + k));
    const __m512i z = _mm512_sub_epi16(own_z, _mm512_loadu_si512(all_z + k));
    const __m512i r2 = _mm512_add_epi32(_mm512_madd_epi16(xy, xy), _mm512_madd_epi16(z, z));
    const __mmask16 inside = _mm512_cmple_epi32_mask(r2, near);
    unsigned hit = _mm512_mask_cmpneq_epi32_mask(inside, offset, own_offset);
    if (count - k < 16) hit &= (1u << (count - k)) - 1;
    _mm512_storeu_si512(next, _mm512_maskz_compress_epi32((__mmask16)hit, offset));
    next += __builtin_popcount(hit);
  }
#elif HC_HAS_AVX2
  const __m256i own_xy = _mm256_set1_epi32(cut_xy(self)), own_z = _mm256_set1_epi32(cut_z(self)),
                own_offset = _mm256_set1_epi32((int)self_offset), beyond = _mm256_set1_epi32(most + 1);
  for (int32_t k = 0; k < count; k += 8) {
    const __m256i offset = _mm256_loadu_si256((const __m256i *)(all_offsets + k));
    const __m256i xy = _mm256_sub_epi16(own_xy, _mm256_loadu_si256((const __m256i *)(all_xy + k)));
    const __m256i z = _mm256_sub_epi16(own_z, _mm256_loadu_si256((const __m256i *)(all_z + k)));
    const __m256i r2 = _mm256_add_epi32(_mm256_madd_epi16(xy, xy), _mm256_madd_epi16(z, z));
    const __m256i inside = _mm256_cmpgt_epi32(beyond, r2);
    const __m256i hit = _mm256_andnot_si256(_mm256_cmpeq_epi32(offset, own_offset), inside);
    unsigned bits = (unsigned)_mm256_movemask_ps(_mm256_castsi256_ps(hit));
    if (count - k < 8) bits &= (1u << (count - k)) - 1;
    const __m256i places = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((long long)hc_compress_places[bits]));
    _mm256_storeu_si256((__m256i *)next, _mm256_permutevar8x32_epi32(offset, places));
    next += __builtin_popcount(bits);
  }
#else
  const int32_t own_xy = cut_xy(self), own_z = cut_z(self);
  for (int32_t k = 0; k < count; k++) {
    const int32_t x = (int16_t)((uint32_t)own_xy - (uint32_t)all_xy[k]), z = (int16_t)(own_z - all_z[k]),
                  y = (int16_t)(((uint32_t)own_xy >> 16) - ((uint32_t)all_xy[k] >> 16));
    *next = all_offsets[k];
    next += x * x + y * y + z * z <= most && all_offsets[k] != self_offset;
  }
#endif
  return (int32_t)(next - out);
}

static size_t rows(hc_neighbors *list, const hc_neighbor_search *search, int32_t begin, int32_t end,
                   const hc_record *place, hc_selection selection, bool same, size_t used) {
  uint32_t *const begins = list->row, *const entries = list->offset;
  const int32_t most = near_of(search);
  int64_t pairs = 0;
  for (int32_t row = selection.begin; row < selection.end; row++) {
    const int32_t i = hc_selected(selection, row);
    const uint32_t self = same ? (uint32_t)i * (uint32_t)sizeof(hc_record) : UINT32_MAX;
    uint32_t *out = entries + used;
    const int32_t hits = filter(search->xy + begin, search->z + begin, search->offset + begin, end - begin,
                                &place[i], self, most, out);
    const uint32_t filler = same || hits == 0 ? self : out[0];
    for (int pad = 0; pad < HC_LIST_GROUP; pad++) out[hits + pad] = filler;
    const uint32_t fillers = -(uint32_t)hits % HC_LIST_GROUP;
    begins[row] = (uint32_t)used | fillers;
    pairs += hits;
    used += (size_t)hits + fillers;
  }
  list->pairs += pairs;
  return used;
}

const hc_neighbor_loops *HC_ISA_SYMBOL(hc_neighbor_loops)(void) {
  static const hc_neighbor_loops loops = {append, rows};
  return &loops;
}
