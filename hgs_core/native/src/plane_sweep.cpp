// The depth at which every pixel of a picture agrees best with other pictures: a plane sweep (Collins, CVPR 1996).
//
// Pictures are compared by the normalised correlation of windows, which brightness and contrast of cameras do not change.
// At each depth the sources that fit best count, as others may be blocked. What a blank pixel cannot say its neighbours
// tell it: semi_global.cpp.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "api.hpp"
#include "semi_global.hpp"

namespace hgs {
namespace {

constexpr int kReach = 4;         // pixels of a window on either side of its middle
constexpr int kBest = 3;          // sources that count at a depth
constexpr float kContrast = 1e-3f;  // variance of grey that counts as noise: correlations of less are weak
constexpr float kUnseen = 4.0f;   // cost in a source that does not see the point
constexpr float kBlind = 0.9f;    // cost of a depth that no source sees

// Rows with room for windows that reach out of them; zero there.
class Plane {
 public:
  Plane(int width, int height) : stride_(width + 2 * kReach), data_(static_cast<size_t>(stride_) * height) {}

  float *row(int y) { return data_.data() + static_cast<size_t>(y) * stride_ + kReach; }
  const float *row(int y) const { return data_.data() + static_cast<size_t>(y) * stride_ + kReach; }

 private:
  int stride_;
  std::vector<float> data_;
};

// Loops over a row, apart so that the compiler knows that their arrays do not overlap.

// Where the pixels of a row lie in a source: the corner before each, how far beyond it, and whether it is inside.
void locate(const float *start, const float *slope, int source_width, int source_height, int width, int *__restrict corner,
            float *__restrict across, float *__restrict down, float *__restrict seen) {
  const float wide = static_cast<float>(source_width), high = static_cast<float>(source_height);
  const float u0 = start[0], v0 = start[1], w0 = start[2], du = slope[0], dv = slope[1], dw = slope[2];
  for (int x = 0; x < width; ++x) {
    const float step = static_cast<float>(x), w = w0 + dw * step, inverse = 1.0f / std::max(w, 1e-6f);
    const float u = (u0 + du * step) * inverse, v = (v0 + dv * step) * inverse;
    const bool inside = (w > 1e-6f) & (u >= 0.0f) & (u < wide) & (v >= 0.0f) & (v < high);
    const float i = std::min(std::max(u - 0.5f, 0.0f), wide - 1.0f), j = std::min(std::max(v - 0.5f, 0.0f), high - 1.0f);
    const int column = std::min(static_cast<int>(i), source_width - 2), row = std::min(static_cast<int>(j), source_height - 2);
    corner[x] = row * source_width + column;
    across[x] = i - static_cast<float>(column);
    down[x] = j - static_cast<float>(row);
    seen[x] = inside ? 1.0f : 0.0f;
  }
}

void interpolate(const float *__restrict grey, int source_width, const int *__restrict corner,
                 const float *__restrict across, const float *__restrict down, int width, float *__restrict out) {
  const float *__restrict below = grey + source_width;
  for (int x = 0; x < width; ++x) {
    const float upper = grey[corner[x]] + across[x] * (grey[corner[x] + 1] - grey[corner[x]]);
    const float lower = below[corner[x]] + across[x] * (below[corner[x] + 1] - below[corner[x]]);
    out[x] = upper + down[x] * (lower - upper);
  }
}

void multiply(const float *__restrict a, const float *__restrict b, int width, float *__restrict out) {
  for (int x = 0; x < width; ++x) out[x] = a[x] * b[x];
}

// Sums over 2 kReach + 1 values; `in` has room on either side.
void window_sums(const float *__restrict in, int width, float *__restrict out) {
  for (int x = 0; x < width; ++x) {
    float total = in[x - kReach];
    for (int k = 1 - kReach; k <= kReach; ++k) total += in[x + k];
    out[x] = total;
  }
}

void add(const float *__restrict row, int width, float *__restrict total) {
  for (int x = 0; x < width; ++x) total[x] += row[x];
}

// What one row of a picture is like, per pixel: means and standard deviations of the windows.
struct Moments {
  const float *mean, *deviation, *share;  // `share` of a window that one pixel of it is
};

// Costs from the sums over windows of a source, its squares and its products with the picture; the best ones are kept.
void rank(const Moments &own, const float *__restrict sum, const float *__restrict square, const float *__restrict product,
          const float *__restrict seen, int width, float *__restrict first, float *__restrict second,
          float *__restrict third) {
  const float *__restrict own_mean = own.mean, *__restrict deviation = own.deviation, *__restrict share = own.share;
  for (int x = 0; x < width; ++x) {
    const float mean = sum[x] * share[x], variance = std::max(square[x] * share[x] - mean * mean, 0.0f);
    const float covariance = product[x] * share[x] - mean * own_mean[x];
    const float correlation = covariance / (deviation[x] * std::sqrt(variance) + kContrast);
    const float matched = 0.5f * (1.0f - std::min(std::max(correlation, -1.0f), 1.0f));
    const float cost = seen[x] > 0.0f ? matched : kUnseen;
    const float worse = std::max(first[x], cost), worst = std::max(second[x], worse);
    first[x] = std::min(first[x], cost);
    second[x] = std::min(second[x], worse);
    third[x] = std::min(third[x], worst);
  }
}

class Matcher {
 public:
  Matcher(const float *grey, int width, int height)
      : width_(width),
        height_(height),
        own_(width, height),
        mean_(width, height),
        deviation_(width, height),
        share_(width, height),
        warped_(width, height),
        seen_(width, height),
        along_{Plane(width, height), Plane(width, height), Plane(width, height)},
        best_{Plane(width, height), Plane(width, height), Plane(width, height)},
        products_(width + 2 * kReach),
        sums_(static_cast<size_t>(3) * width),
        across_(width),
        down_(width),
        corner_(width) {
    for (int y = 0; y < height; ++y) std::copy_n(grey + static_cast<size_t>(y) * width, width, own_.row(y));
    // The own moments once, by the same sums; the product is left out.
    for (int y = 0; y < height; ++y) sum_along(own_.row(y), own_.row(y), y);
    for (int y = 0; y < height; ++y) {
      const int rows = std::min(y + kReach, height - 1) - std::max(y - kReach, 0) + 1;
      float *const share = share_.row(y), *const mean = mean_.row(y), *const deviation = deviation_.row(y);
      for (int x = 0; x < width; ++x) {
        const int columns = std::min(x + kReach, width - 1) - std::max(x - kReach, 0) + 1;
        share[x] = 1.0f / static_cast<float>(rows * columns);
      }
      std::fill_n(mean, width, 0.0f);
      std::fill_n(deviation, width, 0.0f);
      for_window_rows(y, [&](int row) {
        add(along_[0].row(row), width, mean);
        add(along_[1].row(row), width, deviation);
      });
      for (int x = 0; x < width; ++x) {
        mean[x] *= share[x];
        deviation[x] = std::sqrt(std::max(deviation[x] * share[x] - mean[x] * mean[x], 0.0f));
      }
    }
  }

  // The cost of one depth for every pixel, to costs[y][x][place], of `depths` places.
  void match(const hgs_sweep_source *sources, int count, double depth, int place, int depths, uint16_t *costs) {
    for (int k = 0; k < kBest; ++k) {
      for (int y = 0; y < height_; ++y) std::fill_n(best_[k].row(y), width_, kUnseen);
    }
    for (int s = 0; s < count; ++s) compare(sources[s], depth);
    for (int y = 0; y < height_; ++y) {
      const float *const a = best_[0].row(y), *const b = best_[1].row(y), *const c = best_[2].row(y);
      uint16_t *const out = costs + static_cast<size_t>(y) * width_ * depths + place;
      for (int x = 0; x < width_; ++x) {
        const float seen = static_cast<float>((a[x] < kUnseen) + (b[x] < kUnseen) + (c[x] < kUnseen));
        const float total = a[x] + b[x] + c[x] - kUnseen * (kBest - seen);
        const float cost = seen > 0.0f ? total / seen : kBlind;
        out[static_cast<size_t>(x) * depths] = static_cast<uint16_t>(cost * kCostUnits + 0.5f);
      }
    }
  }

 private:
  template <class F>
  void for_window_rows(int y, F &&f) const {
    for (int row = std::max(y - kReach, 0); row <= std::min(y + kReach, height_ - 1); ++row) f(row);
  }

  // Sums along row y of a picture, its squares and its products with another, over 2 kReach + 1 pixels.
  void sum_along(const float *picture, const float *other, int y) {
    float *const products = products_.data() + kReach;
    window_sums(picture, width_, along_[0].row(y));
    multiply(picture, picture, width_, products);
    window_sums(products, width_, along_[1].row(y));
    multiply(picture, other, width_, products);
    window_sums(products, width_, along_[2].row(y));
  }

  // The source as the picture's camera would see it if everything were at this depth.
  void warp(const hgs_sweep_source &source, double depth) {
    const double *const m = source.map;
    for (int y = 0; y < height_; ++y) {
      float start[3], slope[3];
      for (int i = 0; i < 3; ++i) {
        slope[i] = static_cast<float>(m[4 * i] * depth);
        start[i] = static_cast<float>((m[4 * i] * 0.5 + m[4 * i + 1] * (y + 0.5) + m[4 * i + 2]) * depth + m[4 * i + 3]);
      }
      locate(start, slope, source.width, source.height, width_, corner_.data(), across_.data(), down_.data(), seen_.row(y));
      interpolate(source.grey, source.width, corner_.data(), across_.data(), down_.data(), width_, warped_.row(y));
    }
  }

  // One source at one depth, into the best costs.
  void compare(const hgs_sweep_source &source, double depth) {
    warp(source, depth);
    for (int y = 0; y < height_; ++y) sum_along(warped_.row(y), own_.row(y), y);
    float *const sum = sums_.data(), *const square = sum + width_, *const product = square + width_;
    for (int y = 0; y < height_; ++y) {
      std::fill(sums_.begin(), sums_.end(), 0.0f);
      for_window_rows(y, [&](int row) {
        add(along_[0].row(row), width_, sum);
        add(along_[1].row(row), width_, square);
        add(along_[2].row(row), width_, product);
      });
      rank({mean_.row(y), deviation_.row(y), share_.row(y)}, sum, square, product, seen_.row(y), width_, best_[0].row(y),
           best_[1].row(y), best_[2].row(y));
    }
  }

  int width_, height_;
  Plane own_, mean_, deviation_, share_, warped_, seen_, along_[3], best_[kBest];
  std::vector<float> products_, sums_, across_, down_;
  std::vector<int> corner_;
};

}  // namespace
}  // namespace hgs

extern "C" int32_t hgs_plane_sweep(const float *grey, int32_t width, int32_t height, const hgs_sweep_source *sources,
                                   int32_t count, const double *depths, int32_t depth_count, float *places,
                                   float *costs) {
  return hgs::guarded([&] {
    std::vector<uint16_t> volume(static_cast<size_t>(width) * height * depth_count);
    {
      hgs::Matcher matcher(grey, width, height);
      for (int d = 0; d < depth_count; ++d) matcher.match(sources, count, depths[d], d, depth_count, volume.data());
    }
    hgs::semi_global(volume.data(), grey, width, height, depth_count, places, costs);
    return HGS_OK;
  });
}
