// Treat denormal floats as zero within a scope, on the calling thread.
#pragma once

#include <cstdint>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace hgs {

#if defined(__x86_64__)

class ScopedFlushToZero {
 public:
  ScopedFlushToZero() : saved_(_mm_getcsr()) { _mm_setcsr(saved_ | kFlushToZero | kDenormalsAreZero); }
  ~ScopedFlushToZero() { _mm_setcsr(saved_); }
  ScopedFlushToZero(const ScopedFlushToZero &) = delete;
  ScopedFlushToZero &operator=(const ScopedFlushToZero &) = delete;

 private:
  static constexpr unsigned kFlushToZero = 1u << 15, kDenormalsAreZero = 1u << 6;
  unsigned saved_;
};

#elif defined(__aarch64__)

class ScopedFlushToZero {
 public:
  ScopedFlushToZero() {
    asm volatile("mrs %0, fpcr" : "=r"(saved_));
    asm volatile("msr fpcr, %0" : : "r"(saved_ | kFlushToZero));
  }
  ~ScopedFlushToZero() { asm volatile("msr fpcr, %0" : : "r"(saved_)); }
  ScopedFlushToZero(const ScopedFlushToZero &) = delete;
  ScopedFlushToZero &operator=(const ScopedFlushToZero &) = delete;

 private:
  static constexpr uint64_t kFlushToZero = 1u << 24;
  uint64_t saved_ = 0;
};

#else

class ScopedFlushToZero {
 public:
  ScopedFlushToZero() {}
  ~ScopedFlushToZero() {}
};

#endif

}  // namespace hgs
