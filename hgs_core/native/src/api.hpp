// The border between C++ and C.
#pragma once

#include <new>

#include "hgs_native.h"

namespace hgs {

// Run f, which returns a status, and turn exceptions into one.
template <class F>
int32_t guarded(F &&f) noexcept {
  try {
    return f();
  } catch (const std::bad_alloc &) {
    return HGS_OUT_OF_MEMORY;
  } catch (...) {
    return HGS_FAILED;
  }
}

}  // namespace hgs
