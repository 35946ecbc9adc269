// Parallel loops over a pool of threads that lives as long as the process.
//
// The pool survives fork (the child starts a fresh one) and may be used from several threads, of which one has
// the threads and the others do their loops themselves until it is their turn.
// Every loop flushes denormals to zero for its duration only: they are slow, and no result needs them.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <type_traits>

#include "flush_to_zero.hpp"

namespace hgs {

// Call task(context, t) for t in [0, threads), on threads of their own if no other caller has them, else one after the
// other; tasks must not wait for each other. Rethrows the first exception.
void run_on_threads(int threads, void (*task)(void *context, int thread), void *context);

template <class F>
void run_on_threads(int threads, F &&f) {
  run_on_threads(
      threads,
      [](void *context, int thread) {
        const ScopedFlushToZero flush;
        (*static_cast<std::remove_reference_t<F> *>(context))(thread);
      },
      &f);
}

// Call f(i) for i in [0, count); threads take the next `grain` indices as they become free.
template <class F>
void parallel_for(int threads, int64_t count, int64_t grain, F &&f) {
  std::atomic<int64_t> next{0};
  const int64_t useful = (count + grain - 1) / grain;
  run_on_threads(static_cast<int>(std::clamp<int64_t>(useful, 1, threads)), [&](int) {
    for (;;) {
      const int64_t begin = next.fetch_add(grain, std::memory_order_relaxed);
      if (begin >= count) return;
      const int64_t end = std::min(count, begin + grain);
      for (int64_t i = begin; i < end; ++i) f(i);
    }
  });
}

// Call f(thread, begin, end) once per thread on equal, consecutive ranges of [0, count).
template <class F>
void parallel_ranges(int threads, int64_t count, F &&f) {
  run_on_threads(threads, [&](int thread) { f(thread, count * thread / threads, count * (thread + 1) / threads); });
}

}  // namespace hgs
