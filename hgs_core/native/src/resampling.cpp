// Pictures resampled at positions that are known beforehand. Compiled without contraction: numpy's bits.
#include <cstdint>

#include "api.hpp"

namespace hgs {
namespace {

template <int channels>
void blend(const uint8_t *picture, int width, const int32_t *corners, const float *right, const float *lower,
           int64_t count, uint8_t *out) {
  for (int64_t i = 0; i < count; ++i) {
    const uint8_t *const above = picture + static_cast<int64_t>(corners[i]) * channels;
    const uint8_t *const below = above + static_cast<int64_t>(width) * channels;
    for (int c = 0; c < channels; ++c) {
      float upper = above[c], under = below[c];
      upper += right[i] * (static_cast<float>(above[c + channels]) - upper);
      under += right[i] * (static_cast<float>(below[c + channels]) - under);
      upper += lower[i] * (under - upper) + 0.5f;
      out[i * channels + c] = static_cast<uint8_t>(upper);
    }
  }
}

}  // namespace
}  // namespace hgs

extern "C" int32_t hgs_resample(const uint8_t *picture, int32_t width, int32_t channels, const int32_t *corners,
                                const float *right, const float *lower, int64_t count, uint8_t *out) {
  return hgs::guarded([&] {
    const auto blend = channels == 3 ? hgs::blend<3> : hgs::blend<1>;
    blend(picture, width, corners, right, lower, count, out);
    return HGS_OK;
  });
}
