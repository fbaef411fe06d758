/* Vectors for the pair loops: GNU C vector types, with intrinsics where GNU C has no word for it. The only
 * file with instruction-set specifics besides the *_isa.c loops that include it.
 *
 * A row of a neighbour list is groups of eight. Whatever the vector length, lane k of the even groups adds up
 * on its own, lane k of the odd groups too; at the end odd is added to even and the eight sums in a fixed
 * tree (hc_sum_rows). AVX-512 takes an even and an odd group at once, the others one after the other: the
 * same bits.
 *
 * A multiply-add is written hc_fma wherever it is wanted; nothing is contracted behind our back
 * (-ffp-contract=off). Without FMA hardware it rounds twice, so the portable build gives other bits. */
#ifndef HC_SIMD_H
#define HC_SIMD_H

#include <math.h>
#include <stdint.h>
#include <string.h>
#if defined(__AVX2__) && defined(__FMA__)
#  include <immintrin.h>
#endif

/* name -> name_avx2 and so on: the symbol of this translation unit's instruction set. */
#define HC_ISA_PASTE(name, isa) name##_##isa
#define HC_ISA_EXPAND(name, isa) HC_ISA_PASTE(name, isa)
#define HC_ISA_SYMBOL(name) HC_ISA_EXPAND(name, HC_ISA)

#define HC_INLINE static inline __attribute__((always_inline))

enum { HC_GROUP = 8 };

#if defined(__AVX512F__)
#  define HC_HAS_AVX512 1
#  define HC_HAS_AVX2 1
enum { HC_LANES = 16, HC_PARTS = 1 };
#elif defined(__AVX2__) && defined(__FMA__)
#  define HC_HAS_AVX512 0
#  define HC_HAS_AVX2 1
enum { HC_LANES = 8, HC_PARTS = 2 };
#else
#  define HC_HAS_AVX512 0
#  define HC_HAS_AVX2 0
enum { HC_LANES = 8, HC_PARTS = 2 };
#endif

typedef float hc_float __attribute__((vector_size(4 * HC_LANES)));
typedef int32_t hc_int __attribute__((vector_size(4 * HC_LANES)));
typedef uint32_t hc_unsigned __attribute__((vector_size(4 * HC_LANES)));

HC_INLINE hc_float hc_set(float value) {
#if HC_HAS_AVX512
  return (hc_float)_mm512_set1_ps(value);
#else
  return (hc_float){value, value, value, value, value, value, value, value};
#endif
}

HC_INLINE hc_int hc_set_int(int32_t value) {
#if HC_HAS_AVX512
  return (hc_int)_mm512_set1_epi32(value);
#else
  return (hc_int){value, value, value, value, value, value, value, value};
#endif
}

HC_INLINE hc_int hc_lane_numbers(void) {
#if HC_HAS_AVX512
  return (hc_int){0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
#else
  return (hc_int){0, 1, 2, 3, 4, 5, 6, 7};
#endif
}

/* a * b + c */
HC_INLINE hc_float hc_fma(hc_float a, hc_float b, hc_float c) {
#if HC_HAS_AVX512
  return (hc_float)_mm512_fmadd_ps((__m512)a, (__m512)b, (__m512)c);
#elif HC_HAS_AVX2
  return (hc_float)_mm256_fmadd_ps((__m256)a, (__m256)b, (__m256)c);
#else
  return a * b + c;
#endif
}

HC_INLINE hc_float hc_sqrt(hc_float a) {
#if HC_HAS_AVX512
  return (hc_float)_mm512_sqrt_ps((__m512)a);
#elif HC_HAS_AVX2
  return (hc_float)_mm256_sqrt_ps((__m256)a);
#else
  hc_float root;
  for (int lane = 0; lane < HC_LANES; lane++) root[lane] = sqrtf(a[lane]);
  return root;
#endif
}

/* The larger and the smaller; b if either is no number. */
HC_INLINE hc_float hc_max(hc_float a, hc_float b) {
#if HC_HAS_AVX512
  return (hc_float)_mm512_max_ps((__m512)a, (__m512)b);
#elif HC_HAS_AVX2
  return (hc_float)_mm256_max_ps((__m256)a, (__m256)b);
#else
  const hc_int mask = a > b;
  return (hc_float)(((hc_int)a & mask) | ((hc_int)b & ~mask));
#endif
}

HC_INLINE hc_float hc_min(hc_float a, hc_float b) {
#if HC_HAS_AVX512
  return (hc_float)_mm512_min_ps((__m512)a, (__m512)b);
#elif HC_HAS_AVX2
  return (hc_float)_mm256_min_ps((__m256)a, (__m256)b);
#else
  const hc_int mask = a < b;
  return (hc_float)(((hc_int)a & mask) | ((hc_int)b & ~mask));
#endif
}

/* a - b, wrapping around: the difference of two fixed-point coordinates of nearby particles. */
HC_INLINE hc_int hc_wrapped_difference(hc_int a, hc_int b) {
  return (hc_int)((hc_unsigned)a - (hc_unsigned)b);
}

HC_INLINE hc_float hc_from_int(hc_int a) {
  return __builtin_convertvector(a, hc_float);
}

/* `value` in the lanes below `count`, 0 in the others. */
HC_INLINE hc_float hc_keep(hc_float value, int32_t count) {
#if HC_HAS_AVX512
  const __mmask16 mask = _mm512_cmplt_epi32_mask((__m512i)hc_lane_numbers(), _mm512_set1_epi32(count));
  return (hc_float)_mm512_maskz_mov_ps(mask, (__m512)value);
#else
  return (hc_float)((hc_int)value & (hc_lane_numbers() < hc_set_int(count)));
#endif
}

/* The same where `count` is a multiple of HC_GROUP and at least that: nothing to do where a vector is one
 * group. */
HC_INLINE hc_float hc_keep_groups(hc_float value, int32_t count) {
#if HC_HAS_AVX512
  const unsigned odd = (unsigned)(HC_GROUP - count) >> 31; /* no branch: nobody could predict it */
  return (hc_float)_mm512_maskz_mov_ps((__mmask16)(0xffu | (0u - odd)), (__m512)value);
#else
  (void)count;
  return value;
#endif
}

/* Stores the sums of even and odd groups' lanes, eight floats. */
HC_INLINE void hc_store_lanes(const hc_float part[HC_PARTS], float lanes[HC_GROUP]) {
#if HC_HAS_AVX512
  _mm256_store_ps(lanes, _mm256_add_ps(_mm512_castps512_ps256((__m512)part[0]),
                                       _mm512_extractf32x8_ps((__m512)part[0], 1)));
#else
  const hc_float both = part[0] + part[1];
  memcpy(lanes, &both, sizeof both);
#endif
}

/* sum[k] = ((a0 + a2) + (a1 + a3)) + ((a4 + a6) + (a5 + a7)) of row k, for eight rows of eight lanes. */
HC_INLINE void hc_sum_rows(const float *rows, float sum[HC_GROUP]) {
#if HC_HAS_AVX2
  __m256 half[2];
  for (int k = 0; k < 2; k++) {
    const __m256 a = _mm256_load_ps(rows + 32 * k), b = _mm256_load_ps(rows + 32 * k + 8),
                 c = _mm256_load_ps(rows + 32 * k + 16), d = _mm256_load_ps(rows + 32 * k + 24);
    const __m256 ab = _mm256_add_ps(_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
    const __m256 cd = _mm256_add_ps(_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
    half[k] = _mm256_add_ps(_mm256_shuffle_ps(ab, cd, 0x44), _mm256_shuffle_ps(ab, cd, 0xee));
  }
  _mm256_store_ps(sum, _mm256_add_ps(_mm256_permute2f128_ps(half[0], half[1], 0x20),
                                     _mm256_permute2f128_ps(half[0], half[1], 0x31)));
#else
  for (int k = 0; k < HC_GROUP; k++) {
    const float *a = rows + HC_GROUP * k;
    sum[k] = ((a[0] + a[2]) + (a[1] + a[3])) + ((a[4] + a[6]) + (a[5] + a[7]));
  }
#endif
}

/* Loads as many 16-byte records as there are lanes, at byte offsets from `base`, and transposes them: lane k
 * of column c is word c of the record at offset[k]. */
HC_INLINE void hc_load_records(const void *base, const uint32_t *offset, hc_int column[4]) {
#define HC_AT(k) ((const float *)((const char *)base + offset[k]))
#if HC_HAS_AVX512
  /* Masked broadcasts put a record in place without the shuffle unit, which the transposition keeps busy. */
#  define HC_PUT(into, mask, k) _mm512_mask_broadcast_f32x4(into, mask, _mm_load_ps(HC_AT(k)))
#  define HC_FOUR(k)                                                                                         \
    HC_PUT(HC_PUT(HC_PUT(_mm512_castps128_ps512(_mm_load_ps(HC_AT(k))), 0x00f0, (k) + 4), 0x0f00, (k) + 8),  \
           0xf000, (k) + 12)
  const __m512 a = HC_FOUR(0), b = HC_FOUR(1), c = HC_FOUR(2), d = HC_FOUR(3);
#  undef HC_FOUR
#  undef HC_PUT
  const __m512 ab_low = _mm512_unpacklo_ps(a, b), ab_high = _mm512_unpackhi_ps(a, b);
  const __m512 cd_low = _mm512_unpacklo_ps(c, d), cd_high = _mm512_unpackhi_ps(c, d);
  column[0] = (hc_int)_mm512_shuffle_ps(ab_low, cd_low, 0x44);
  column[1] = (hc_int)_mm512_shuffle_ps(ab_low, cd_low, 0xee);
  column[2] = (hc_int)_mm512_shuffle_ps(ab_high, cd_high, 0x44);
  column[3] = (hc_int)_mm512_shuffle_ps(ab_high, cd_high, 0xee);
#elif HC_HAS_AVX2
#  define HC_TWO(k)                                                                                          \
    _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(HC_AT(k))), _mm_load_ps(HC_AT((k) + 4)), 1)
  const __m256 a = HC_TWO(0), b = HC_TWO(1), c = HC_TWO(2), d = HC_TWO(3);
#  undef HC_TWO
  const __m256 ab_low = _mm256_unpacklo_ps(a, b), ab_high = _mm256_unpackhi_ps(a, b);
  const __m256 cd_low = _mm256_unpacklo_ps(c, d), cd_high = _mm256_unpackhi_ps(c, d);
  column[0] = (hc_int)_mm256_shuffle_ps(ab_low, cd_low, 0x44);
  column[1] = (hc_int)_mm256_shuffle_ps(ab_low, cd_low, 0xee);
  column[2] = (hc_int)_mm256_shuffle_ps(ab_high, cd_high, 0x44);
  column[3] = (hc_int)_mm256_shuffle_ps(ab_high, cd_high, 0xee);
#else
  for (int lane = 0; lane < HC_LANES; lane++) {
    int32_t words[4];
    memcpy(words, HC_AT(lane), sizeof words);
    for (int word = 0; word < 4; word++) column[word][lane] = words[word];
  }
#endif
#undef HC_AT
}

#endif
