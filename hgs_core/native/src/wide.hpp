// kLanes doubles, for the few steps whose rounding in float32 would show on the screen.
#pragma once

#include <cmath>

#include "simd.hpp"

namespace hgs {

// In two vectors of the native width: GCC compiles wider ones badly.
constexpr int kHalf = kLanes / 2;
using VecDouble = double __attribute__((vector_size(8 * kHalf)));

struct Wide {
  VecDouble low, high;
};

inline Wide operator+(Wide a, Wide b) { return {a.low + b.low, a.high + b.high}; }
inline Wide operator-(Wide a, Wide b) { return {a.low - b.low, a.high - b.high}; }
inline Wide operator*(Wide a, Wide b) { return {a.low * b.low, a.high * b.high}; }
inline Wide operator/(Wide a, Wide b) { return {a.low / b.low, a.high / b.high}; }
inline Wide operator*(double a, Wide b) { return {a * b.low, a * b.high}; }
inline Wide broadcast_wide(double x) { return {x - VecDouble{}, x - VecDouble{}}; }

#if HGS_AVX512
inline Wide widen(Vec v) {
  const __m512 x = (__m512)v;
  return {(VecDouble)_mm512_cvtps_pd(_mm512_castps512_ps256(x)),
          (VecDouble)_mm512_cvtps_pd(_mm512_extractf32x8_ps(x, 1))};
}
inline Vec narrow(Wide w) {
  const __m256 low = _mm512_cvtpd_ps((__m512d)w.low), high = _mm512_cvtpd_ps((__m512d)w.high);
  return (Vec)_mm512_insertf32x8(_mm512_castps256_ps512(low), high, 1);
}
#elif HGS_AVX2
inline Wide widen(Vec v) {
  const __m256 x = (__m256)v;
  return {(VecDouble)_mm256_cvtps_pd(_mm256_castps256_ps128(x)),
          (VecDouble)_mm256_cvtps_pd(_mm256_extractf128_ps(x, 1))};
}
inline Vec narrow(Wide w) {
  return (Vec)_mm256_set_m128(_mm256_cvtpd_ps((__m256d)w.high), _mm256_cvtpd_ps((__m256d)w.low));
}
#else
// Not lane by lane: GCC 12 compiles v - widen(narrow(v)) to zero then.
using VecHalf = float __attribute__((vector_size(4 * kHalf)));
inline Wide widen(Vec v) {
  VecHalf half[2];
  std::memcpy(half, &v, sizeof v);
  return {__builtin_convertvector(half[0], VecDouble), __builtin_convertvector(half[1], VecDouble)};
}
inline Vec narrow(Wide w) {
  const VecHalf half[] = {__builtin_convertvector(w.low, VecHalf), __builtin_convertvector(w.high, VecHalf)};
  Vec v;
  std::memcpy(&v, half, sizeof v);
  return v;
}
#endif

inline Wide clamp(Wide x, double low, double high) {
  const VecDouble l = low - VecDouble{}, h = high - VecDouble{};
  const auto limited = [&](VecDouble v) {
    v = v < l ? l : v;
    return v > h ? h : v;
  };
  return {limited(x.low), limited(x.high)};
}

// The nearest whole number, for |x| < 2^51.
inline Wide round(Wide x) {
  const Wide shift = broadcast_wide(6755399441055744.0);  // 1.5 * 2^52
  return (x + shift) - shift;
}

}  // namespace hgs
