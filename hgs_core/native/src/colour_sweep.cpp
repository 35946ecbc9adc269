// The coarse plane sweep: what points along the rays of some pixels look like in other pictures, by colours alone.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <vector>

#include "api.hpp"

namespace hgs {
namespace {

constexpr int kChannels = 3, kValues = 2 * kChannels;  // of a descriptor: means over 3x3 and over 7x7 pixels
constexpr int kReach = 3;                              // pixels of the larger window on either side of its middle

// Sums over the rows of a window, with room on both sides; zero there.
class ColumnSums {
 public:
  explicit ColumnSums(int width) : data_((width + 2 * kReach) * kChannels), count_(width * kChannels) {}

  void add(const uint8_t *row, int sign) {
    int16_t *const sums = data_.data() + kReach * kChannels;
    for (int i = 0; i < count_; ++i) sums[i] = static_cast<int16_t>(sums[i] + sign * row[i]);
  }

  // The sum over the columns of a window as well, around value i of the row.
  template <int reach>
  int window(int i) const {
    int sum = 0;
    for (int shift = -reach; shift <= reach; ++shift) sum += data_[i + (kReach + shift) * kChannels];
    return sum;
  }

 private:
  std::vector<int16_t> data_;
  int count_;
};

void describe(const uint8_t *picture, int width, int height, uint8_t *descriptors) {
  const auto row_at = [&](int y) { return picture + static_cast<size_t>(y) * width * kChannels; };
  const auto slide = [&](ColumnSums &sums, int y, int reach) {  // from the window around row y - 1 to that around y
    if (y + reach < height) sums.add(row_at(y + reach), 1);
    if (y - reach - 1 >= 0) sums.add(row_at(y - reach - 1), -1);
  };
  ColumnSums narrow(width), wide(width);
  for (int y = 0; y < std::min(1, height); ++y) narrow.add(row_at(y), 1);
  for (int y = 0; y < std::min(kReach, height); ++y) wide.add(row_at(y), 1);
  for (int y = 0; y < height; ++y) {
    slide(narrow, y, 1);
    slide(wide, y, kReach);
    uint8_t *const out = descriptors + static_cast<size_t>(y) * width * kValues;
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < kChannels; ++c) {
        out[x * kValues + c] = static_cast<uint8_t>(narrow.window<1>(x * kChannels + c) / 9);
        out[x * kValues + kChannels + c] = static_cast<uint8_t>(wide.window<kReach>(x * kChannels + c) / 49);
      }
    }
  }
}

// A ray in a view: the pixel at depth z is ((a0 z + b0) / w, (a1 z + b1) / w), with w = a2 z + b2.
struct SeenRay {
  double a[3], b[3];

  SeenRay(const double *map, const double *origin, const double *ray) {
    for (int i = 0; i < 3; ++i, map += 4) {
      a[i] = map[0] * ray[0] + map[1] * ray[1] + map[2] * ray[2];
      b[i] = map[0] * origin[0] + map[1] * origin[1] + map[2] * origin[2] + map[3];
    }
  }

  // The number of the pixel at a depth, or -1 outside of the picture and behind the camera.
  int64_t pixel(double depth, int width, int height, double nearest) const {
    const double w = a[2] * depth + b[2];
    if (!(w > nearest)) return -1;
    const double x = (a[0] * depth + b[0]) / w, y = (a[1] * depth + b[1]) / w;
    if (!(x >= 0 && x < width && y >= 0 && y < height)) return -1;
    return static_cast<int64_t>(y) * width + static_cast<int64_t>(x);
  }
};

float difference(const uint8_t *first, const uint8_t *second) {
  int sum = 0;
  for (int i = 0; i < kValues; ++i) sum += std::abs(first[i] - second[i]);
  return static_cast<float>(sum) / kValues;
}

struct Sweep {
  const double *origin, *depths;
  int depth_count;
  const hgs_colour_source *sources;
  int source_count;
  const hgs_hull_view *hull;
  int hull_count;
  double hull_share;
  float blind;
  std::vector<float> slots;        // [source_count][depth_count]
  std::vector<int> facing, inside;  // [depth_count]

  void ray(const double *direction, const uint8_t *own, float *costs) {
    for (int s = 0; s < source_count; ++s) compare(sources[s], direction, own, slots.data() + s * depth_count);
    const int counted = std::max(1, source_count - 1);  // without the source that fits worst, which may be blocked
    for (int d = 0; d < depth_count; ++d) {
      float sum = 0.0f, worst = 0.0f;
      for (int s = 0; s < source_count; ++s) {
        const float cost = slots[s * depth_count + d];
        sum += cost;
        worst = std::max(worst, cost);
      }
      costs[d] = (source_count > 1 ? sum - worst : sum) / static_cast<float>(counted);
    }
    if (hull_count > 0) leave_hull(direction, costs);
  }

 private:
  void compare(const hgs_colour_source &source, const double *direction, const uint8_t *own, float *costs) const {
    const SeenRay seen(source.map, origin, direction);
    for (int d = 0; d < depth_count; ++d) {
      const int64_t pixel = seen.pixel(depths[d], source.width, source.height, 1e-6);
      costs[d] = pixel < 0 ? blind : difference(source.descriptors + pixel * kValues, own);
    }
  }

  void leave_hull(const double *direction, float *costs) {
    std::fill(facing.begin(), facing.end(), 0);
    std::fill(inside.begin(), inside.end(), 0);
    for (int v = 0; v < hull_count; ++v) {
      const SeenRay seen(hull[v].map, origin, direction);
      for (int d = 0; d < depth_count; ++d) {
        const int64_t pixel = seen.pixel(depths[d], hull[v].width, hull[v].height, 1e-3);
        if (pixel < 0) continue;
        ++facing[d];
        inside[d] += hull[v].mask[pixel] != 0;
      }
    }
    for (int d = 0; d < depth_count; ++d) {
      if (inside[d] < hull_share * std::max(1, facing[d])) costs[d] = std::numeric_limits<float>::infinity();
    }
  }
};

}  // namespace
}  // namespace hgs

extern "C" {

int32_t hgs_colour_descriptors(const uint8_t *picture, int32_t width, int32_t height, uint8_t *descriptors) {
  return hgs::guarded([&] {
    hgs::describe(picture, width, height, descriptors);
    return HGS_OK;
  });
}

int32_t hgs_colour_sweep(const double *origin, const double *rays, const uint8_t *own, int64_t count,
                         const double *depths, int32_t depth_count, const hgs_colour_source *sources,
                         int32_t source_count, const hgs_hull_view *hull, int32_t hull_count, double hull_share,
                         float blind, float *costs) {
  return hgs::guarded([&] {
    hgs::Sweep sweep{origin, depths, depth_count, sources, source_count, hull, hull_count, hull_share, blind,
                     std::vector<float>(static_cast<size_t>(source_count) * depth_count),
                     std::vector<int>(depth_count), std::vector<int>(depth_count)};
    for (int64_t r = 0; r < count; ++r) sweep.ray(rays + 3 * r, own + hgs::kValues * r, costs + r * depth_count);
    return HGS_OK;
  });
}

}  // extern "C"
