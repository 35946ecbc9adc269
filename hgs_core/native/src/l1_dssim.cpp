// L1 + D-SSIM (Wang et al. 2004) and its gradient, fused.
//
// The picture is cut into bands of rows. A band streams through three stages, each a few rows behind the one before,
// so that everything in between stays in the cache:
//     row r       the pictures and their products, blurred along the row
//     row r - 5   the same blurred along the column -> SSIM and its partial derivatives, blurred along the row
//     row r - 10  the derivatives blurred along the column -> the gradient
// Outside the picture everything is zero, as in a convolution with zero padding.
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
constexpr int kBandRows = 96;
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

// The last 11 rows of several quantities.
template <int quantities>
class Ring {
 public:
  Ring(float *memory, const RowLayout &layout) : memory_(memory), layout_(layout) {}

  static size_t size(const RowLayout &layout) { return static_cast<size_t>(quantities) * kTaps * layout.stride; }

  float *row(int quantity, int y) {
    return memory_ + static_cast<size_t>(quantity * kTaps + (y + 2 * kTaps) % kTaps) * layout_.stride;
  }

  void clear(int y) {
    for (int q = 0; q < quantities; ++q) std::fill_n(row(q, y), layout_.padded, 0.0f);
  }

  // Blur of one quantity along the column at row y.
  class Column {
   public:
    Column(Ring &ring, int quantity, int y) {
      for (int t = 0; t < kTaps; ++t) rows_[t] = ring.row(quantity, y - kRadius + t);
    }
    Vec at(int x) const {
      Vec v = kGaussian[0] * load(rows_[kRadius] + x);
      for (int t = 1; t <= kRadius; ++t) v += kGaussian[t] * (load(rows_[kRadius - t] + x) + load(rows_[kRadius + t] + x));
      return v;
    }

   private:
    const float *rows_[kTaps];
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
        derivatives_(memory + Ring<4>::size(layout_), layout_),
        rows_(memory + Ring<4>::size(layout_) + Ring<3>::size(layout_)) {
    std::fill_n(rows_, static_cast<size_t>(kScratchRows) * layout_.stride, 0.0f);
  }

  static size_t memory_size(int width) {
    const RowLayout layout(width);
    return Ring<4>::size(layout) + Ring<3>::size(layout) + static_cast<size_t>(kScratchRows) * layout.stride;
  }

  BandSums run(int begin, int end) {
    BandSums sums;
    for (int y = begin - 2 * kRadius; y < end + 2 * kRadius; ++y) {
      blur_pictures(y);
      const int middle = y - kRadius;
      if (middle >= begin - kRadius && middle < end + kRadius) {
        const double ssim = differentiate_ssim(middle);
        if (middle >= begin && middle < end) sums.ssim += ssim;
      }
      const int last = y - 2 * kRadius;
      if (last >= begin && last < end) sums.l1 += write_gradient(last);
    }
    return sums;
  }

 private:
  static constexpr int kScratchRows = 4;
  enum Blurred { kImage, kTarget, kSquares, kProduct };     // of Ring<4>
  enum Derivative { kByMean, kBySquares, kByProduct };      // of Ring<3>

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

  // SSIM of row y, summed; its derivatives by the blurred picture, squares and product go to the ring.
  float differentiate_ssim(int y) {
    if (!inside(y)) {
      derivatives_.clear(y);
      return 0;
    }
    const Ring<4>::Column image(blurred_, kImage, y), target(blurred_, kTarget, y), squares(blurred_, kSquares, y),
        product(blurred_, kProduct, y);
    float *const by_mean = scratch(0), *const by_squares = scratch(1), *const by_product = scratch(2);
    Vec total{};
    for (int x = 0; x < layout_.padded; x += kLanes) {
      const Vec m1 = image.at(x), m2 = target.at(x), means = m1 * m1 + m2 * m2;
      const Vec a1 = 2.0f * m1 * m2 + kC1, a2 = 2.0f * (product.at(x) - m1 * m2) + kC2;
      const Vec b1 = means + kC1, b2 = squares.at(x) - means + kC2;
      const Vec inverse = reciprocal(b1 * b2);
      const Mask in_picture = greater(broadcast(static_cast<float>(p_.width - x)), lane_numbers());
      const Vec ssim = keep(in_picture, a1 * a2 * inverse);
      const Vec d_product = 2.0f * a1 * inverse, d_squares = -ssim * b1 * inverse;
      const Vec d_mean = 2.0f * m2 * (a2 - a1) * inverse + 2.0f * m1 * ssim * (b1 - b2) * inverse;
      total += ssim;
      store(by_mean + x, keep(in_picture, p_.ssim_scale * d_mean));
      store(by_squares + x, keep(in_picture, p_.ssim_scale * d_squares));
      store(by_product + x, keep(in_picture, p_.ssim_scale * d_product));
    }
    blur_row(by_mean, derivatives_.row(kByMean, y), layout_);
    blur_row(by_squares, derivatives_.row(kBySquares, y), layout_);
    blur_row(by_product, derivatives_.row(kByProduct, y), layout_);
    return sum(total);
  }

  // The gradient of row y; returns the sum of its absolute differences.
  float write_gradient(int y) {
    const float *const image = copy_row(p_.image, y, 0), *const target = copy_row(p_.target, y, 1);
    float *const out = scratch(2);
    const Ring<3>::Column by_mean(derivatives_, kByMean, y), by_squares(derivatives_, kBySquares, y),
        by_product(derivatives_, kByProduct, y);
    const Vec zero{};
    Vec total{};
    for (int x = 0; x < layout_.padded; x += kLanes) {
      const Vec a = load(image + x), b = load(target + x), difference = a - b;
      const Vec sign = keep(greater(difference, zero), broadcast(p_.l1_scale)) -
                       keep(greater(zero, difference), broadcast(p_.l1_scale));
      total += max(difference, -difference);
      store(out + x, by_mean.at(x) + 2.0f * a * by_squares.at(x) + b * by_product.at(x) + sign);
    }
    std::memcpy(p_.gradient + static_cast<size_t>(y) * p_.width, out, sizeof(float) * p_.width);
    return sum(total);
  }

  LossParameters p_;
  RowLayout layout_;
  Ring<4> blurred_;
  Ring<3> derivatives_;
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
