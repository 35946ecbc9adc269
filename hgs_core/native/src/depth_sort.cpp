// A radix sort whose result does not depend on the number of threads: it is stable, and threads own consecutive ranges.
#include "depth_sort.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "thread_pool.hpp"

namespace hgs {
namespace {

constexpr int kDigitBits = 11, kDigits = 1 << kDigitBits, kPasses = 3;
constexpr int64_t kWorthAThread = 65536;  // splats: a pass over fewer takes less time than to wake a thread for it

uint32_t digit(uint64_t key, int pass) { return key >> (32 + pass * kDigitBits) & (kDigits - 1); }

// Move the keys of one pass from `from` to `to`.
void sort_digit(const uint64_t *from, uint64_t *to, int64_t n, int pass, uint32_t *counts, int threads) {
  parallel_ranges(threads, n, [&](int thread, int64_t begin, int64_t end) {
    uint32_t *const mine = counts + static_cast<size_t>(thread) * kDigits;
    std::fill_n(mine, kDigits, 0);
    for (int64_t i = begin; i < end; ++i) ++mine[digit(from[i], pass)];
  });
  uint32_t place = 0;
  for (int d = 0; d < kDigits; ++d) {
    for (int t = 0; t < threads; ++t) place += std::exchange(counts[static_cast<size_t>(t) * kDigits + d], place);
  }
  parallel_ranges(threads, n, [&](int thread, int64_t begin, int64_t end) {
    uint32_t *const mine = counts + static_cast<size_t>(thread) * kDigits;
    for (int64_t i = begin; i < end; ++i) to[mine[digit(from[i], pass)]++] = from[i];
  });
}

}  // namespace

void sort_by_depth(ScreenSet &set, BinningScratch &scratch, int threads) {
  const int64_t n = set.visible_count;
  threads = static_cast<int>(std::clamp<int64_t>(n / kWorthAThread, 1, threads));
  uint64_t *keys = scratch.keys.reserve(n), *other_keys = scratch.other_keys.reserve(n);
  uint32_t *const counts = scratch.digit_counts.reserve(static_cast<size_t>(threads) * kDigits);
  uint32_t *const order = set.order.reserve(n);
  parallel_ranges(threads, n, [&](int, int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      const uint32_t splat = set.visible[i];
      uint32_t depth;  // positive, so its bits sort as it does
      std::memcpy(&depth, &set.splats[splat].depth, sizeof depth);
      keys[i] = static_cast<uint64_t>(depth) << 32 | splat;
    }
  });
  for (int pass = 0; pass < kPasses; ++pass) {
    sort_digit(keys, other_keys, n, pass, counts, threads);
    std::swap(keys, other_keys);
  }
  parallel_ranges(threads, n, [&](int, int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) order[i] = static_cast<uint32_t>(keys[i]);
  });
}

}  // namespace hgs
