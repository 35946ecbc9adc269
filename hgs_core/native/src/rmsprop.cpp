// One step of RMSprop, fused.
#include <algorithm>
#include <cmath>

#include "api.hpp"
#include "thread_pool.hpp"

namespace {

// The step of one value: v = decay v + gained g^2, p -= rate g / (inverse_root sqrt(v) + epsilon).
struct Step {
  float gained, inverse_root, epsilon;

  void take(float &p, float &v, float g, float decay, float rate) const {
    v = decay * v + gained * g * g;
    p -= rate * g / (std::sqrt(v) * inverse_root + epsilon);
  }
};

}  // namespace

extern "C" int32_t hgs_rmsprop(int64_t rows, int64_t width, const int64_t *row_of, float *parameters,
                               const float *gradients, float *moments, const float *decays, double beta,
                               const float *factors, int64_t values_per_factor, double learning_rate,
                               double correction, double epsilon, int32_t threads) {
  const Step step{static_cast<float>(1.0 - beta), static_cast<float>(1.0 / std::sqrt(correction)),
                  static_cast<float>(epsilon)};
  const auto rate = static_cast<float>(learning_rate), all_decay = static_cast<float>(beta);

  // Blocks are the same for any number of threads: where a loop's vector part ends can change the last bit.
  const int64_t block_rows = std::max<int64_t>(1, 4096 / std::max<int64_t>(1, width));
  constexpr int64_t kWorthAThread = 32;  // blocks: fewer take less time than to wake a thread for them
  return hgs::guarded([&] {
    hgs::parallel_for(threads, (rows + block_rows - 1) / block_rows, kWorthAThread, [=](int64_t block) {
      const int64_t begin = block * block_rows, end = std::min(rows, begin + block_rows);
      if (row_of == nullptr && decays == nullptr && factors == nullptr) {
        float *__restrict p = parameters, *__restrict v = moments;
        const float *__restrict g = gradients;
        for (int64_t i = begin * width; i < end * width; ++i) step.take(p[i], v[i], g[i], all_decay, rate);
        return;
      }
      // The factor of the first value, and how many values it is left for.
      const float *factor = factors == nullptr ? nullptr : factors + begin * width / values_per_factor;
      int64_t left = factors == nullptr ? rows * width : values_per_factor - begin * width % values_per_factor;
      float scaled = factors == nullptr ? rate : rate * *factor;
      for (int64_t r = begin; r < end; ++r) {
        const int64_t to = (row_of == nullptr ? r : row_of[r]) * width;
        const float decay = decays == nullptr ? all_decay : decays[r];
        float *__restrict p = parameters + to, *__restrict v = moments + to;
        const float *__restrict g = gradients + r * width;
        for (int64_t c = 0; c < width; ++c, --left) {
          if (left == 0) {
            left = values_per_factor;
            scaled = rate * *++factor;
          }
          step.take(p[c], v[c], g[c], decay, scaled);
        }
      }
    });
    return HGS_OK;
  });
}
