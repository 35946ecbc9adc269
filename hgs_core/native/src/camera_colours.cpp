// What a camera makes of the colours of a picture, A (gain rgb) + b with the falloff of its lens as gain, and the
// derivative. A pass over the picture each: memory is what they wait for, and in parts they would wait several times.
#include <cstddef>
#include <vector>

#include "api.hpp"
#include "lanes.hpp"
#include "thread_pool.hpp"

namespace hgs {
namespace {

constexpr int kFalloff = 12, kSums = 14;  // dL / d affine [3][4] up to kFalloff, then dL / d falloff
constexpr int64_t kWorthAThread = 32;     // rows: fewer take less time than to wake a thread for them

struct Row {
  const hgs_camera_colours &colours;
  float down_squared;  // of the row's distance to the principal point, in halves of the diagonal

  Row(const hgs_camera_colours &c, int64_t y) : colours(c) {
    const double down = (static_cast<double>(y) + 0.5 - c.cy) / c.half_diagonal;
    down_squared = static_cast<float>(down * down);
  }

  // r^2 of the pixels from x on, and the gain there.
  Vec radius_squared(int x) const {
    const auto first = static_cast<float>(x + 0.5 - colours.cx), scale = static_cast<float>(1.0 / colours.half_diagonal);
    const Vec across = (lane_numbers() + first) * scale;
    return across * across + down_squared;
  }
  Vec gain(Vec squared) const { return 1.0f + squared * (colours.falloff[0] + colours.falloff[1] * squared); }
};

// Calls vector(x, lanes) for all vectors of a row, of which the last may be a part of one.
template <class F>
inline void along_row(int width, F &&vector) {
  const int whole = width / kLanes * kLanes;
  for (int x = 0; x < whole; x += kLanes) vector(x, kLanes);
  if (whole < width) vector(whole, width - whole);
}

void show_row(const hgs_camera_colours &colours, const float *picture, int64_t plane, int width, int64_t y, float *shown) {
  const Row row(colours, y);
  const float *const a = colours.affine;
  along_row(width, [&](int x, int lanes) __attribute__((always_inline)) {
    const float *const from = picture + y * width + x;
    const Vec gain = row.gain(row.radius_squared(x));
    Vec rgb[3];
    for (int c = 0; c < 3; ++c) rgb[c] = gain * load_lanes(from + c * plane, lanes);
    for (int c = 0; c < 3; ++c) {
      const Vec mapped = a[4 * c] * rgb[0] + a[4 * c + 1] * rgb[1] + a[4 * c + 2] * rgb[2] + a[4 * c + 3];
      store_lanes(shown + c * plane + y * width + x, mapped, lanes);
    }
  });
}

void pull_row_back(const hgs_camera_colours &colours, const float *picture, const float *gradient, int64_t plane, int width,
                   int64_t y, float *pulled, double *sums) {
  const Row row(colours, y);
  const float *const a = colours.affine;
  Vec totals[kSums] = {};
  along_row(width, [&](int x, int lanes) __attribute__((always_inline)) {
    const int64_t pixel = y * width + x;
    const Vec squared = row.radius_squared(x), gain = row.gain(squared);
    Vec by_shown[3], by_gain{};
    for (int c = 0; c < 3; ++c) {
      by_shown[c] = load_lanes(gradient + c * plane + pixel, lanes);  // zero beyond the row, and so is all that follows
      totals[4 * c + 3] += by_shown[c];
    }
    for (int c = 0; c < 3; ++c) {
      const Vec colour = load_lanes(picture + c * plane + pixel, lanes), lit = gain * colour;
      for (int i = 0; i < 3; ++i) totals[4 * i + c] += by_shown[i] * lit;
      const Vec by_lit = a[c] * by_shown[0] + a[4 + c] * by_shown[1] + a[8 + c] * by_shown[2];
      by_gain += colour * by_lit;
      store_lanes(pulled + c * plane + pixel, gain * by_lit, lanes);
    }
    totals[kFalloff] += by_gain * squared;
    totals[kFalloff + 1] += by_gain * squared * squared;
  });
  for (int i = 0; i < kSums; ++i) sums[i] = sum(totals[i]);
}

}  // namespace
}  // namespace hgs

extern "C" int32_t hgs_camera_shown(const hgs_camera_colours *colours, const float *picture, int32_t width, int32_t height,
                                    int32_t threads, float *shown) {
  using namespace hgs;
  const int64_t plane = static_cast<int64_t>(width) * height;
  return guarded([&] {
    parallel_for(threads, height, kWorthAThread, [&](int64_t y) { show_row(*colours, picture, plane, width, y, shown); });
    return HGS_OK;
  });
}

extern "C" int32_t hgs_camera_shown_backward(const hgs_camera_colours *colours, const float *picture, const float *gradient,
                                             int32_t width, int32_t height, int32_t threads, float *pulled, float *affine,
                                             float *falloff) {
  using namespace hgs;
  const int64_t plane = static_cast<int64_t>(width) * height;
  return guarded([&] {
    // Sums of every row, added up in their order: the same bits however the rows were shared out.
    std::vector<double> sums(static_cast<size_t>(kSums) * height);
    parallel_for(threads, height, kWorthAThread, [&](int64_t y) {
      pull_row_back(*colours, picture, gradient, plane, width, y, pulled, sums.data() + kSums * y);
    });
    double totals[kSums] = {};
    for (size_t i = 0; i < sums.size(); ++i) totals[i % kSums] += sums[i];
    for (int i = 0; i < kFalloff; ++i) affine[i] = static_cast<float>(totals[i]);
    for (int i = kFalloff; i < kSums; ++i) falloff[i - kFalloff] = static_cast<float>(totals[i]);
    return HGS_OK;
  });
}
