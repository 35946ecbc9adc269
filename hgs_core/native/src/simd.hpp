// Vectors of floats, as wide as the instruction set this file is compiled for.
//
// The vector extensions of GCC and Clang give the arithmetic; what they cannot express well (masks, reductions) is
// written with intrinsics for AVX-512 and AVX2 and in portable form for everything else.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace hgs {

#if defined(__AVX512F__)
#define HGS_AVX512 1
constexpr int kLanes = 16;
#elif defined(__AVX2__)
#define HGS_AVX2 1
constexpr int kLanes = 8;
#else
constexpr int kLanes = 4;
#endif

using Vec = float __attribute__((vector_size(4 * kLanes)));
using VecBits = uint32_t __attribute__((vector_size(4 * kLanes)));
using VecInt = int32_t __attribute__((vector_size(4 * kLanes)));

constexpr float kLog2E = 1.44269504088896341f;
constexpr float kLn2 = 0.693147180559945309f;

// Subtracting zero is exact for every float, so the compiler removes it.
inline Vec broadcast(float x) { return x - Vec{}; }
inline Vec load(const float *p) { return *reinterpret_cast<const Vec *>(p); }
inline void store(float *p, Vec v) { *reinterpret_cast<Vec *>(p) = v; }
// A copy, not a vector type of lower alignment: Clang ignores that attribute where GCC heeds it.
inline Vec load_unaligned(const float *p) {
  Vec v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
inline void store_unaligned(float *p, Vec v) { std::memcpy(p, &v, sizeof v); }
inline VecBits bits_of(Vec v) { return (VecBits)v; }
inline Vec from_bits(VecBits b) { return (Vec)b; }

// The first lanes of a vector from and to memory of any alignment; the others are zero and are left alone.
inline Vec load_lanes(const float *from, int count) {
  if (count == kLanes) return load_unaligned(from);
#if HGS_AVX512
  return (Vec)_mm512_maskz_loadu_ps(static_cast<__mmask16>((1u << count) - 1), from);
#endif
  alignas(64) float lanes[kLanes] = {};
  std::copy_n(from, count, lanes);
  return load(lanes);
}
inline void store_lanes(float *to, Vec v, int count) {
  if (count == kLanes) return store_unaligned(to, v);
#if HGS_AVX512
  return _mm512_mask_storeu_ps(to, static_cast<__mmask16>((1u << count) - 1), (__m512)v);
#endif
  alignas(64) float lanes[kLanes];
  store(lanes, v);
  std::copy_n(lanes, count, to);
}

// 0, 1, 2, ... in the lanes.
inline Vec lane_numbers() {
  Vec v{};
  for (int i = 0; i < kLanes; ++i) v[i] = static_cast<float>(i);
  return v;
}

// ---- masks: keep(m, v) zeroes the lanes outside m --------------------------------------------------------------------

#if HGS_AVX512

using Mask = __mmask16;
inline Mask greater_equal(Vec a, Vec b) { return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_GE_OQ); }
inline Mask greater(Vec a, Vec b) { return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_GT_OQ); }
inline Mask both(Mask a, Mask b) { return a & b; }
inline bool any(Mask m) { return m != 0; }
inline uint32_t lane_bits(Mask m) { return m; }
inline Vec select(Mask m, Vec yes, Vec no) { return (Vec)_mm512_mask_blend_ps(m, (__m512)no, (__m512)yes); }
inline Vec keep(Mask m, Vec v) { return (Vec)_mm512_maskz_mov_ps(m, (__m512)v); }
inline Vec min(Vec a, Vec b) { return (Vec)_mm512_min_ps((__m512)a, (__m512)b); }
inline Vec max(Vec a, Vec b) { return (Vec)_mm512_max_ps((__m512)a, (__m512)b); }
inline Vec sqrt(Vec x) { return (Vec)_mm512_sqrt_ps((__m512)x); }

#else

using Mask = VecInt;
inline Mask greater_equal(Vec a, Vec b) { return a >= b; }
inline Mask greater(Vec a, Vec b) { return a > b; }
inline Mask both(Mask a, Mask b) { return a & b; }
inline Vec select(Mask m, Vec yes, Vec no) { return m ? yes : no; }
inline Vec keep(Mask m, Vec v) { return from_bits(bits_of(v) & (VecBits)m); }
#if HGS_AVX2
inline uint32_t lane_bits(Mask m) { return static_cast<uint32_t>(_mm256_movemask_ps((__m256)m)); }
inline Vec min(Vec a, Vec b) { return (Vec)_mm256_min_ps((__m256)a, (__m256)b); }
inline Vec max(Vec a, Vec b) { return (Vec)_mm256_max_ps((__m256)a, (__m256)b); }
inline Vec sqrt(Vec x) { return (Vec)_mm256_sqrt_ps((__m256)x); }
#else
inline uint32_t lane_bits(Mask m) {
  uint32_t bits = 0;
  for (int i = 0; i < kLanes; ++i) bits |= (m[i] & 1u) << i;
  return bits;
}
inline Vec min(Vec a, Vec b) { return a < b ? a : b; }
inline Vec max(Vec a, Vec b) { return a > b ? a : b; }
inline Vec sqrt(Vec x) {
  for (int i = 0; i < kLanes; ++i) x[i] = std::sqrt(x[i]);
  return x;
}
#endif
inline bool any(Mask m) { return lane_bits(m) != 0; }

#endif

inline Vec negative(Vec x) { return from_bits(bits_of(x) | 0x80000000u); }
inline Vec abs(Vec x) { return from_bits(bits_of(x) & 0x7fffffffu); }
inline Vec clamp(Vec x, float low, float high) { return min(max(x, broadcast(low)), broadcast(high)); }

// ---- functions ------------------------------------------------------------------------------------------------------

// 1 / x, to about 1 unit in the last place; x normal.
inline Vec reciprocal(Vec x) {
#if HGS_AVX512
  const Vec r = (Vec)_mm512_rcp14_ps((__m512)x);
  return r * (2.0f - x * r);
#elif HGS_AVX2
  const Vec r = (Vec)_mm256_rcp_ps((__m256)x);
  return r * (2.0f - x * r);
#else
  return 1.0f / x;
#endif
}

// y / x, to about 2 units in the last place; x normal.
inline Vec quotient(Vec y, Vec x) {
#if HGS_AVX512
  const Vec r = (Vec)_mm512_rcp14_ps((__m512)x), q = y * r;
#elif HGS_AVX2
  const Vec r = (Vec)_mm256_rcp_ps((__m256)x), q = y * r;
#else
  return y / x;
#endif
#if HGS_AVX512 || HGS_AVX2
  return q + q * (1.0f - x * r);
#endif
}

// 2^x for x in [-126, 127], relative error 2e-7; garbage (but no trap) outside, which callers mask or clamp.
#if HGS_AVX512
// 2^x = 2^n (2^(i/32) 2^f): the powers in between lie in two registers, and a parabola is enough for |f| <= 1/64.
struct PowersBetween {
  alignas(64) uint32_t less[32];  // bits of 2^(i/32), less what i becomes when n is shifted to the exponent
  constexpr PowersBetween() : less{} {
    double power = 1.0;
    for (uint32_t i = 0; i < 32; ++i, power *= 1.0218971486541166) {
      less[i] = 0x3f800000u + static_cast<uint32_t>((power - 1.0) * 0x1p23 + 0.5) - (i << 18);
    }
  }
};
inline Vec exp2(Vec x) {
  static constexpr PowersBetween table;
  constexpr float kRound = 393216.0f;  // 1.5 * 2^18: adding it rounds to 32nds in the low bits
  const Vec shifted = x + kRound;
  const Vec f = x - (shifted - kRound);
  const __m512i between = _mm512_permutex2var_epi32(_mm512_load_si512(table.less), (__m512i)shifted,
                                                    _mm512_load_si512(table.less + 16));
  const Vec power = from_bits((VecBits)between + (bits_of(shifted) << 18));
  return power + power * ((f * 2.402265e-1f + 6.931573e-1f) * f);
}
#else
// The polynomial is the minimax fit of 2^f on [-1/2, 1/2].
inline Vec exp2(Vec x) {
  constexpr float kRound = 12582912.0f;  // 1.5 * 2^23: adding it rounds to an integer in the low bits
  const Vec shifted = x + kRound;
  const Vec f = x - (shifted - kRound);
  // By Estrin's scheme: a shorter chain of dependent operations than Horner's.
  const Vec f2 = f * f;
  const Vec high = (f * 1.327647152e-3f + 9.675541331e-3f) * f2 + (f * 5.550713275e-2f + 2.402211972e-1f);
  const Vec p = high * f2 + (f * 6.931469671e-1f + 1.000000072f);
  return from_bits(bits_of(p) + (bits_of(shifted) << 23));
}
#endif

// e^x, relative error 1e-7, saturating at 2^-120 and 2^120. The rest of x log2(e) beyond an integer is taken in two steps,
// so that large x keep their digits (exactly so where there are fused multiply-adds).
inline Vec exp(Vec x) {
  constexpr float kRound = 12582912.0f;                                // 1.5 * 2^23: rounds to an integer
  constexpr float kLog2EHigh = 1.44269502f, kLog2ELow = 1.92596299e-8f;  // log2(e)
  x = clamp(x, -120.0f * kLn2, 120.0f * kLn2);
  const Vec shifted = x * kLog2EHigh + kRound;
  const Vec f = (x * kLog2EHigh - (shifted - kRound)) + x * kLog2ELow;
  Vec p = f * 1.535336188e-4f + 1.339887442e-3f;
  p = p * f + 9.618437358e-3f;
  p = p * f + 5.550332471e-2f;
  p = p * f + 2.402264791e-1f;
  p = p * f + 6.931472029e-1f;
  p = p * f + 1.0f;
  return from_bits(bits_of(p) + (bits_of(shifted) << 23));
}

// log2(x) for positive normal x. With x = 2^e m, m in [sqrt(1/2), sqrt(2)), ln m = 2 atanh((m - 1) / (m + 1)).
inline Vec log2(Vec x) {
  constexpr uint32_t kSqrtHalf = 0x3f3504f3u;
  const VecBits bits = bits_of(x);
  const VecInt exponent = (VecInt)(bits - kSqrtHalf) >> 23;
  const Vec m = from_bits(bits - ((VecBits)exponent << 23));
  const Vec s = (m - 1.0f) / (m + 1.0f), s2 = s * s;
  const Vec series = 1.0f + s2 * (1.0f / 3 + s2 * (1.0f / 5 + s2 * (1.0f / 7 + s2 * (1.0f / 9))));
  Vec e{};
  for (int i = 0; i < kLanes; ++i) e[i] = static_cast<float>(exponent[i]);
  return e + 2.0f * kLog2E * s * series;
}

// The largest whole number that is not above x, for |x| < 2^22.
inline Vec floor(Vec x) {
  constexpr float kRound = 12582912.0f;
  const Vec nearest = (x + kRound) - kRound;
  return nearest - keep(greater(nearest, x), broadcast(1.0f));
}
inline Vec ceil(Vec x) { return -floor(-x); }

}  // namespace hgs
