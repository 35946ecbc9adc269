// Which x86-64 microarchitecture level (x86-64 psABI, section 3.1.1) the machine can run.
//
// Asked of the processor directly: the compilers' __builtin_cpu_supports needs a runtime library that not all of them
// bring along.
#include "hgs_native.h"

#if defined(__x86_64__)
#include <cpuid.h>

namespace {

bool has(uint32_t value, uint32_t bits) { return (value & bits) == bits; }

// The register states that the operating system saves when it switches threads.
uint32_t saved_states() {
  uint32_t low, high;
  asm volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
  return low;
}

int level() {
  uint32_t c = 0, extended_c = 0, seven_b = 0, other1, other2, other3;
  if (!__get_cpuid(1, &other1, &other2, &c, &other3)) return 1;
  __get_cpuid(0x80000001u, &other1, &other2, &extended_c, &other3);
  __get_cpuid_count(7, 0, &other1, &seven_b, &other2, &other3);

  // SSE3, SSSE3, CMPXCHG16B, SSE4.1, SSE4.2, POPCNT; LAHF
  constexpr uint32_t kV2 = 1u << 0 | 1u << 9 | 1u << 13 | 1u << 19 | 1u << 20 | 1u << 23;
  if (!has(c, kV2) || !has(extended_c, 1u << 0)) return 1;

  // FMA, MOVBE, OSXSAVE, AVX, F16C; LZCNT; BMI1, AVX2, BMI2; states: SSE, AVX
  constexpr uint32_t kV3 = 1u << 12 | 1u << 22 | 1u << 27 | 1u << 28 | 1u << 29;
  if (!has(c, kV3) || !has(extended_c, 1u << 5) || !has(seven_b, 1u << 3 | 1u << 5 | 1u << 8)) return 2;
  const uint32_t states = saved_states();
  if (!has(states, 1u << 1 | 1u << 2)) return 2;

  // AVX-512 F, DQ, CD, BW, VL; states: masks and both halves of the new registers
  constexpr uint32_t kV4 = 1u << 16 | 1u << 17 | 1u << 28 | 1u << 30 | 1u << 31;
  return has(seven_b, kV4) && has(states, 1u << 5 | 1u << 6 | 1u << 7) ? 4 : 3;
}

}  // namespace

extern "C" int32_t hgs_cpu_level(void) { return level(); }

#else

extern "C" int32_t hgs_cpu_level(void) { return 0; }

#endif
