// The machine's own ceiling, against which the benchmarks set the rasterizer.
#include <chrono>

#include "api.hpp"
#include "lanes.hpp"
#include "thread_pool.hpp"

namespace hgs {
namespace {

constexpr int kChains = 12;  // independent of each other: more than latency times units on any processor of interest
constexpr int64_t kRounds = 100000;

// Keeps the compiler from seeing through the loop.
void hide(Vec &v) { asm volatile("" : "+m"(v)); }

float multiply_add() {
  Vec chains[kChains], factor = broadcast(0.999999f), term = broadcast(1e-6f);
  for (int c = 0; c < kChains; ++c) chains[c] = broadcast(static_cast<float>(c));
  hide(factor);
  hide(term);
  for (int64_t round = 0; round < kRounds; ++round) {
    for (int c = 0; c < kChains; ++c) chains[c] = chains[c] * factor + term;
  }
  Vec total{};
  for (int c = 0; c < kChains; ++c) total += chains[c];
  return sum(total);
}

}  // namespace
}  // namespace hgs

extern "C" double hgs_fma_peak(int32_t threads, double seconds) {
  using Clock = std::chrono::steady_clock;
  double operations = 0;
  const auto elapsed = [start = Clock::now()] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  const int32_t status = hgs::guarded([&] {
    volatile float sink = 0;
    do {
      hgs::run_on_threads(threads, [&](int thread) {
        const float result = hgs::multiply_add();
        if (thread == 0) sink = result;
      });
      operations += 2.0 * hgs::kLanes * hgs::kChains * hgs::kRounds * threads;
    } while (elapsed() < seconds);
    return HGS_OK;
  });
  return status == HGS_OK ? operations / elapsed() : 0.0;
}
