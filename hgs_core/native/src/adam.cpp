// One step of Adam, fused.
#include <algorithm>
#include <cmath>

#include "api.hpp"
#include "thread_pool.hpp"

extern "C" int32_t hgs_adam(int64_t n, float *parameters, const float *gradients, float *first_moments,
                            float *second_moments, const float *factors, int64_t values_per_factor,
                            double learning_rate, double beta1, double beta2, double epsilon, int64_t step,
                            int32_t threads) {
  // With m and v the moments and c1, c2 their bias corrections, p -= lr (m / c1) / (sqrt(v / c2) + eps).
  const double correction1 = 1.0 - std::pow(beta1, static_cast<double>(step));
  const double correction2 = 1.0 - std::pow(beta2, static_cast<double>(step));
  const auto rate = static_cast<float>(learning_rate / correction1);
  const auto inverse_root2 = static_cast<float>(1.0 / std::sqrt(correction2));
  const auto eps = static_cast<float>(epsilon);
  const auto b1 = static_cast<float>(beta1), b2 = static_cast<float>(beta2);
  const auto one_less_b1 = static_cast<float>(1.0 - beta1), one_less_b2 = static_cast<float>(1.0 - beta2);

  // Blocks are the same for any number of threads: where a loop's vector part ends can change the last bit.
  constexpr int64_t kBlock = 4096;
  constexpr int64_t kWorthAThread = 32;  // blocks: fewer take less time than to wake a thread for them
  return hgs::guarded([&] {
    hgs::parallel_for(threads, (n + kBlock - 1) / kBlock, kWorthAThread, [=](int64_t block) {
      const int64_t begin = block * kBlock, end = std::min(n, begin + kBlock);
      float rates[kBlock];  // of every value
      if (factors == nullptr) {
        std::fill(rates, rates + (end - begin), rate);
      } else {
        const float *factor = factors + begin / values_per_factor;
        int64_t left = values_per_factor - begin % values_per_factor;  // values of this factor
        for (int64_t i = begin; i < end; ++i, --left) {
          if (left == 0) {
            left = values_per_factor;
            ++factor;
          }
          rates[i - begin] = rate * *factor;
        }
      }
      float *__restrict p = parameters, *__restrict m = first_moments, *__restrict v = second_moments;
      const float *__restrict g = gradients;
      for (int64_t i = begin; i < end; ++i) {
        const float mi = b1 * m[i] + one_less_b1 * g[i];
        const float vi = b2 * v[i] + one_less_b2 * g[i] * g[i];
        m[i] = mi;
        v[i] = vi;
        p[i] -= rates[i - begin] * mi / (std::sqrt(vi) * inverse_root2 + eps);
      }
    });
    return HGS_OK;
  });
}
