// What goes across the lanes of a vector: sums, and the even and odd ones apart.
#pragma once

#include "simd.hpp"

namespace hgs {

// ---- every second lane -----------------------------------------------------------------------------------------------

// The even and the odd ones of 2 kLanes values in a row.
inline void split(Vec first, Vec second, Vec &even, Vec &odd) {
#if HGS_AVX512
  const __m512i lanes = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
  const __m512 a = (__m512)first, b = (__m512)second;
  even = (Vec)_mm512_permutex2var_ps(a, lanes, b);
  odd = (Vec)_mm512_permutex2var_ps(a, _mm512_add_epi32(lanes, _mm512_set1_epi32(1)), b);
#elif HGS_AVX2
  const auto in_order = [](__m256 v) { return (Vec)_mm256_permute4x64_pd(_mm256_castps_pd(v), 0xd8); };
  even = in_order(_mm256_shuffle_ps((__m256)first, (__m256)second, 0x88));
  odd = in_order(_mm256_shuffle_ps((__m256)first, (__m256)second, 0xdd));
#else
  const Vec a = first, b = second;
  for (int i = 0; i < kLanes; ++i) {
    even[i] = i < kLanes / 2 ? a[2 * i] : b[2 * i - kLanes];
    odd[i] = i < kLanes / 2 ? a[2 * i + 1] : b[2 * i + 1 - kLanes];
  }
#endif
}

// The inverse of split.
inline void interleave(Vec even, Vec odd, Vec &first, Vec &second) {
#if HGS_AVX512
  const __m512i low = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
  const __m512 a = (__m512)even, b = (__m512)odd;
  first = (Vec)_mm512_permutex2var_ps(a, low, b);
  second = (Vec)_mm512_permutex2var_ps(a, _mm512_add_epi32(low, _mm512_set1_epi32(8)), b);
#elif HGS_AVX2
  const __m256 a = _mm256_unpacklo_ps((__m256)even, (__m256)odd), b = _mm256_unpackhi_ps((__m256)even, (__m256)odd);
  first = (Vec)_mm256_permute2f128_ps(a, b, 0x20);
  second = (Vec)_mm256_permute2f128_ps(a, b, 0x31);
#else
  const Vec a = even, b = odd;
  for (int i = 0; i < kLanes; ++i) {
    first[i] = i % 2 == 0 ? a[i / 2] : b[i / 2];
    second[i] = i % 2 == 0 ? a[(i + kLanes) / 2] : b[(i + kLanes) / 2];
  }
#endif
}

// ---- sums over the lanes --------------------------------------------------------------------------------------------

inline float sum(Vec v) {
#if HGS_AVX512
  return _mm512_reduce_add_ps((__m512)v);
#elif HGS_AVX2
  __m128 x = _mm_add_ps(_mm256_castps256_ps128((__m256)v), _mm256_extractf128_ps((__m256)v, 1));
  x = _mm_add_ps(x, _mm_movehl_ps(x, x));
  return _mm_cvtss_f32(_mm_add_ss(x, _mm_movehdup_ps(x)));
#else
  return (v[0] + v[1]) + (v[2] + v[3]);
#endif
}

// out[k] = sum of v[k], k < 10; out has room for 16, at a multiple of 64 bytes.
inline void sum_each_of_12(const Vec *v, float *out) {
#if HGS_AVX512
  // Quarters of two vectors, then of four, are added side by side; then the lanes of a quarter.
  const auto halves = [](Vec a, Vec b) {
    return _mm512_add_ps(_mm512_shuffle_f32x4((__m512)a, (__m512)b, 0x44), _mm512_shuffle_f32x4((__m512)a, (__m512)b, 0xee));
  };
  const auto quarters = [](__m512 a, __m512 b) {
    return _mm512_add_ps(_mm512_shuffle_f32x4(a, b, 0x88), _mm512_shuffle_f32x4(a, b, 0xdd));
  };
  const auto pairs = [](__m512 a, __m512 b) { return _mm512_add_ps(_mm512_unpacklo_ps(a, b), _mm512_unpackhi_ps(a, b)); };
  const __m512 first = quarters(halves(v[0], v[1]), halves(v[2], v[3]));
  const __m512 second = quarters(halves(v[4], v[5]), halves(v[6], v[7]));
  const __m512 third = quarters(halves(v[8], v[9]), halves(v[10], v[11]));
  const __m512 a = pairs(first, second), b = pairs(third, third);
  const __m512 sums = _mm512_add_ps(_mm512_shuffle_ps(a, b, 0x44), _mm512_shuffle_ps(a, b, 0xee));
  const __m512i order = _mm512_setr_epi32(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15);
  _mm512_store_ps(out, _mm512_permutexvar_ps(order, sums));
#elif HGS_AVX2
  const __m256 *h = reinterpret_cast<const __m256 *>(v);
  const __m256 low = _mm256_hadd_ps(_mm256_hadd_ps(h[0], h[1]), _mm256_hadd_ps(h[2], h[3]));
  const __m256 high = _mm256_hadd_ps(_mm256_hadd_ps(h[4], h[5]), _mm256_hadd_ps(h[6], h[7]));
  _mm256_store_ps(out, _mm256_add_ps(_mm256_permute2f128_ps(low, high, 0x20), _mm256_permute2f128_ps(low, high, 0x31)));
  for (int k = 8; k < 12; ++k) out[k] = sum(v[k]);
#else
  for (int k = 0; k < 12; ++k) out[k] = sum(v[k]);
#endif
}

}  // namespace hgs
