// L1 + D-SSIM (Wang et al. 2004) and its gradient, fused.
//
// The picture is cut into bands of rows. A band streams through three stages, four rows at a time, each a few rows behind
// the one before, so that everything in between stays in the cache:
//     rows y .. y + 3        the pictures and their products, blurred along the row
//     rows y - 5 .. y - 2    the same blurred along the column -> SSIM and its partial derivatives, blurred along the row
//     rows y - 10 .. y - 7   the derivatives blurred along the column -> the gradient
// Four rows of a column share 14 rows of input, where one alone reads 11. Outside the picture everything is zero, as in a
// convolution with zero padding.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "api.hpp"
#include "buffer.hpp"
#include "simd.hpp"
#include "thread_pool.hpp"

namespace hgs {
namespace {

constexpr int kRadius = 5, kTaps = 2 * kRadius + 1;
constexpr int kBandRows = 128;
constexpr int kGroup = 4;  // rows
constexpr float kC1 = 0.01f * 0.01f, kC2 = 0.03f * 0.03f;

// Half of a Gaussian with sigma 1.5 pixels, centre first; all taps add up to 1.
std::array<float, kRadius + 1> gaussian() {
  std::array<double, kRadius + 1> taps{};
  double total = 0;
  for (int i = 0; i <= kRadius; ++i) {
    taps[i] = std::exp(-i * i / (2 * 1.5 * 1.5));
    total += i == 0 ? taps[i] : 2 * taps[i];
  }
  std::array<float, kRadius + 1> result{};
  for (int i = 0; i <= kRadius; ++i) result[i] = static_cast<float>(taps[i] / total);
  return result;
}

const std::array<float, kRadius + 1> kGaussian = gaussian();

// Rows are as long as a multiple of the vector, with zeros on either side for the taps that reach out.
struct RowLayout {
  int width, padded, stride;

  explicit RowLayout(int w) : width(w), padded((w + kLanes - 1) / kLanes * kLanes), stride(padded + 32) {}
};

// The last rows of several quantities: all that a group of rows and their taps reach.
template <int quantities>
class Ring {
 public:
  static constexpr int kRows = 16;
  static_assert(kRows >= kGroup + 2 * kRadius && kBandRows % kGroup == 0);

  Ring(float *memory, const RowLayout &layout) : memory_(memory), layout_(layout) {}

  static size_t size(const RowLayout &layout) { return static_cast<size_t>(quantities) * kRows * layout.stride; }

  float *row(int quantity, int y) {
    return memory_ + static_cast<size_t>(quantity * kRows + (y + 2 * kRows) % kRows) * layout_.stride;
  }

  void clear(int y) {
    for (int q = 0; q < quantities; ++q) std::fill_n(row(q, y), layout_.padded, 0.0f);
  }

  // Blur of one quantity along the columns at rows y .. y + kGroup - 1.
  class Columns {
   public:
    Columns(Ring &ring, int quantity, int y) {
      for (int t = 0; t < kReach; ++t) rows_[t] = ring.row(quantity, y - kRadius + t);
    }
    void at(int x, Vec *out) const {
      Vec v[kReach];
      for (int t = 0; t < kReach; ++t) v[t] = load(rows_[t] + x);
      for (int i = 0; i < kGroup; ++i) {
        const Vec *const middle = v + i + kRadius;
        out[i] = kGaussian[0] * middle[0];
        for (int t = 1; t <= kRadius; ++t) out[i] += kGaussian[t] * (middle[-t] + middle[t]);
      }
    }

   private:
    static constexpr int kReach = kGroup + 2 * kRadius;
    const float *rows_[kReach];
  };

 private:
  float *memory_;
  RowLayout layout_;
};

// Blur along the row; `in` has zeros on either side.
void blur_row(const float *in, float *out, const RowLayout &layout) {
  for (int x = 0; x < layout.padded; x += kLanes) {
    Vec v = kGaussian[0] * load(in + x);
    for (int t = 1; t <= kRadius; ++t) v += kGaussian[t] * (load_unaligned(in + x - t) + load_unaligned(in + x + t));
    store(out + x, v);
  }
}

struct LossParameters {
  const float *image, *target;  // one channel
  float *gradient;
  int width, height;
  float l1_scale, ssim_scale;  // dL / d of the sum of |image - target| and of the sum of SSIM
};

struct BandSums {
  double l1 = 0, ssim = 0;
};

class Band {
 public:
  Band(const LossParameters &p, float *memory)
      : p_(p),
        layout_(p.width),
        blurred_(memory, layout_),
        derivatives_(memory + Ring<kBlurred>::size(layout_), layout_),
        rows_(memory + Ring<kBlurred>::size(layout_) + Ring<kDerivatives>::size(layout_)) {
    std::fill_n(rows_, static_cast<size_t>(kScratchRows) * layout_.stride, 0.0f);
  }

  static size_t memory_size(int width) {
    const RowLayout layout(width);
    return Ring<kBlurred>::size(layout) + Ring<kDerivatives>::size(layout) +
           static_cast<size_t>(kScratchRows) * layout.stride;
  }

  BandSums run(int begin, int end) {
    BandSums sums;
    for (int y = begin - 2 * kRadius; y < end + 2 * kRadius; y += kGroup) {
      for (int i = 0; i < kGroup; ++i) blur_pictures(y + i);
      // Rows before the band come out of rows that were never blurred; nothing reads them.
      const int middle = y - kRadius, last = y - 2 * kRadius;
      double ssim[kGroup];
      differentiate_ssim(middle, ssim);
      for (int i = 0; i < kGroup; ++i) {
        if (middle + i >= begin && middle + i < end) sums.ssim += ssim[i];
      }
      if (last >= begin) sums.l1 += write_gradient(last, std::min(kGroup, end - last));
    }
    return sums;
  }

 private:
  enum Blurred { kImage, kTarget, kSquares, kProduct, kBlurred };             // of the first ring
  enum Derivative { kByMean, kBySquares, kByProduct, kDerivatives };         // of the second
  static constexpr int kScratchRows = std::max<int>(kBlurred, kGroup * kDerivatives);

  bool inside(int y) const { return y >= 0 && y < p_.height; }

  float *scratch(int i) { return rows_ + static_cast<size_t>(i) * layout_.stride + 16; }

  // A row of a picture in an aligned buffer with zeros behind it.
  const float *copy_row(const float *picture, int y, int i) {
    std::memcpy(scratch(i), picture + static_cast<size_t>(y) * p_.width, sizeof(float) * p_.width);
    std::fill(scratch(i) + p_.width, scratch(i) + layout_.padded, 0.0f);
    return scratch(i);
  }

  void blur_pictures(int y) {
    if (!inside(y)) return blurred_.clear(y);
    const float *const image = copy_row(p_.image, y, 0), *const target = copy_row(p_.target, y, 1);
    float *const squares = scratch(2), *const product = scratch(3);
    for (int x = 0; x < layout_.padded; x += kLanes) {
      const Vec a = load(image + x), b = load(target + x);
      store(squares + x, a * a + b * b);
      store(product + x, a * b);
    }
    blur_row(image, blurred_.row(kImage, y), layout_);
    blur_row(target, blurred_.row(kTarget, y), layout_);
    blur_row(squares, blurred_.row(kSquares, y), layout_);
    blur_row(product, blurred_.row(kProduct, y), layout_);
  }

  // SSIM of rows y .. y + kGroup - 1, each summed; its derivatives by the blurred picture, squares and product go to the
  // ring.
  void differentiate_ssim(int y, double *sums) {
    const Ring<kBlurred>::Columns image(blurred_, kImage, y), target(blurred_, kTarget, y),
        squares(blurred_, kSquares, y), product(blurred_, kProduct, y);
    Vec totals[kGroup] = {};
    for (int x = 0; x < layout_.padded; x += kLanes) {
      Vec mean_1[kGroup], mean_2[kGroup], mean_squares[kGroup], mean_product[kGroup];
      image.at(x, mean_1);
      target.at(x, mean_2);
      squares.at(x, mean_squares);
      product.at(x, mean_product);
      const Mask in_picture = greater(broadcast(static_cast<float>(p_.width - x)), lane_numbers());
      for (int i = 0; i < kGroup; ++i) {
        const Vec m1 = mean_1[i], m2 = mean_2[i], means = m1 * m1 + m2 * m2;
        const Vec a1 = 2.0f * m1 * m2 + kC1, a2 = 2.0f * (mean_product[i] - m1 * m2) + kC2;
        const Vec b1 = means + kC1, b2 = mean_squares[i] - means + kC2;
        const Vec inverse = reciprocal(b1 * b2);
        const Vec ssim = keep(in_picture, a1 * a2 * inverse);
        const Vec d_product = 2.0f * a1 * inverse, d_squares = -ssim * b1 * inverse;
        const Vec d_mean = 2.0f * m2 * (a2 - a1) * inverse + 2.0f * m1 * ssim * (b1 - b2) * inverse;
        totals[i] += ssim;
        store(derivative(i, kByMean) + x, keep(in_picture, p_.ssim_scale * d_mean));
        store(derivative(i, kBySquares) + x, keep(in_picture, p_.ssim_scale * d_squares));
        store(derivative(i, kByProduct) + x, keep(in_picture, p_.ssim_scale * d_product));
      }
    }
    for (int i = 0; i < kGroup; ++i) {
      sums[i] = inside(y + i) ? sum(totals[i]) : 0.0;
      if (!inside(y + i)) {
        derivatives_.clear(y + i);
        continue;
      }
      for (int d = 0; d < kDerivatives; ++d) blur_row(derivative(i, d), derivatives_.row(d, y + i), layout_);
    }
  }

  float *derivative(int row_of_group, int which) { return scratch(row_of_group * kDerivatives + which); }

  // The gradient of `count` rows from y; returns the sum of their absolute differences.
  double write_gradient(int y, int count) {
    const Ring<kDerivatives>::Columns by_mean(derivatives_, kByMean, y), by_squares(derivatives_, kBySquares, y),
        by_product(derivatives_, kByProduct, y);
    const Vec zero{};
    Vec totals[kGroup] = {};
    for (int x = 0; x < layout_.padded; x += kLanes) {
      Vec mean[kGroup], squares[kGroup], product[kGroup];
      by_mean.at(x, mean);
      by_squares.at(x, squares);
      by_product.at(x, product);
      const int lanes = std::min(kLanes, p_.width - x);
      for (int i = 0; i < count; ++i) {
        const size_t pixel = static_cast<size_t>(y + i) * p_.width + x;
        const Vec a = load_lanes(p_.image + pixel, lanes), b = load_lanes(p_.target + pixel, lanes);
        const Vec difference = a - b;
        const Vec sign = keep(greater(difference, zero), broadcast(p_.l1_scale)) -
                         keep(greater(zero, difference), broadcast(p_.l1_scale));
        totals[i] += abs(difference);
        store_lanes(p_.gradient + pixel, mean[i] + 2.0f * a * squares[i] + b * product[i] + sign, lanes);
      }
    }
    double total = 0;
    for (int i = 0; i < count; ++i) total += sum(totals[i]);
    return total;
  }

  LossParameters p_;
  RowLayout layout_;
  Ring<kBlurred> blurred_;
  Ring<kDerivatives> derivatives_;
  float *rows_;
};

}  // namespace
}  // namespace hgs

extern "C" int32_t hgs_l1_dssim(const float *image, const float *target, int32_t width, int32_t height,
                                float dssim_weight, int32_t threads, double *loss, float *gradient) {
  using namespace hgs;
  return guarded([&] {
    const int bands = (height + kBandRows - 1) / kBandRows;
    const size_t plane = static_cast<size_t>(width) * height;
    const double values = 3.0 * static_cast<double>(plane);
    std::vector<BandSums> sums(3 * bands);
    parallel_for(threads, 3 * bands, 1, [&](int64_t unit) {
      const size_t channel = plane * (unit / bands);
      const int begin = static_cast<int>(unit % bands) * kBandRows;
      const LossParameters p{image + channel,
                             target + channel,
                             gradient + channel,
                             width,
                             height,
                             static_cast<float>((1.0 - dssim_weight) / values),
                             static_cast<float>(-dssim_weight / values)};
      static thread_local Buffer<float> memory;
      sums[unit] = Band(p, memory.reserve(Band::memory_size(width))).run(begin, std::min(height, begin + kBandRows));
    });
    double l1 = 0, ssim = 0;
    for (const BandSums &s : sums) {
      l1 += s.l1;
      ssim += s.ssim;
    }
    *loss = (1.0 - dssim_weight) * l1 / values + dssim_weight * (1.0 - ssim / values);
    return HGS_OK;
  });
}
