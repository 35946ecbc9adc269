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
#include <cstring>
#include <vector>

#include "api.hpp"
#include "buffer.hpp"
#include "simd.hpp"
#include "thread_pool.hpp"

namespace hgs {
namespace {

constexpr int kRadius = 5;
constexpr int kLeastBandRows = 64;  // a band computes 20 rows of its neighbours, too
constexpr int kGroup = 4;  // rows
constexpr float kC1 = 0.01f * 0.01f, kC2 = 0.03f * 0.03f;

// Half of a Gaussian with sigma 1.5 pixels, centre first; all taps add up to 1.
constexpr float kGaussian[kRadius + 1] = {0.266011715f,  0.213005543f,   0.109360687f,
                                          0.0360007733f, 0.00759875821f, 0.00102838012f};

// Rows are as long as a multiple of the vector, with zeros on either side for the taps that reach out.
struct RowLayout {
  int width, padded, stride;

  explicit RowLayout(int w) : width(w), padded((w + kLanes - 1) / kLanes * kLanes), stride(padded + 32) {}
};

// The last rows of several quantities: all that a group of rows and their taps reach.
template <int quantities>
class Ring {
 public:
  static constexpr int kRows = kGroup + 2 * kRadius;
  static_assert(4 * kRadius % kGroup == 0, "a group begins with the band");

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
      for (int t = 0; t < kRows; ++t) rows_[t] = ring.row(quantity, y - kRadius + t);
    }

    // Outwards from the middle, so that few rows are in registers at a time.
    void at(int x, Vec *out) const {
      Vec above[kGroup], below[kGroup];
      for (int i = 0; i < kGroup; ++i) {
        above[i] = below[i] = load(rows_[kRadius + i] + x);
        out[i] = kGaussian[0] * above[i];
      }
      for (int t = 1; t <= kRadius; ++t) {
        for (int i = kGroup - 1; i > 0; --i) above[i] = above[i - 1];
        for (int i = 0; i < kGroup - 1; ++i) below[i] = below[i + 1];
        above[0] = load(rows_[kRadius - t] + x);
        below[kGroup - 1] = load(rows_[kRadius + kGroup - 1 + t] + x);
        for (int i = 0; i < kGroup; ++i) out[i] += kGaussian[t] * (above[i] + below[i]);
      }
    }

   private:
    const float *rows_[kRows];
  };

 private:
  float *memory_;
  RowLayout layout_;
};

// The vectors that begin 1 to kRadius places after p; `now` and `next` are those at p and p + kLanes. Where shuffles are
// cheap they take turns with loads, most of which straddle cache lines.
inline void following(const float *p, Vec now, Vec next, Vec *out) {
#if HGS_AVX2
  (void)p;
  const __m256i a = (__m256i)now, b = (__m256i)next, across = _mm256_permute2x128_si256(a, b, 0x21);
  out[0] = (Vec)_mm256_alignr_epi8(across, a, 4);
  out[1] = (Vec)_mm256_alignr_epi8(across, a, 8);
  out[2] = (Vec)_mm256_alignr_epi8(across, a, 12);
  out[3] = (Vec)across;
  out[4] = (Vec)_mm256_alignr_epi8(b, across, 4);
#else
  (void)now, (void)next;
  for (int t = 1; t <= kRadius; ++t) out[t - 1] = load_unaligned(p + t);
#endif
}

// Blur along the row; `in` has zeros on either side.
void blur_row(const float *in, float *out, const RowLayout &layout) {
  Vec now = load(in);
  for (int x = 0; x < layout.padded; x += kLanes) {
    const Vec next = load(in + x + kLanes);
    Vec after[kRadius];
    following(in + x, now, next, after);
    Vec v = kGaussian[0] * now;
    for (int t = 1; t <= kRadius; ++t) v += kGaussian[t] * (load_unaligned(in + x - t) + after[t - 1]);
    store(out + x, v);
    now = next;
  }
}

struct LossParameters {
  const float *image, *target;  // one channel
  float *gradient;
  int width, height;
  float l1_scale, ssim_scale;  // dL / d of the sum of |image - target| and of the sum of SSIM
};

// Sums over one row: adding these up in their order gives the same loss however the rows were shared out.
struct RowSums {
  double l1, ssim;
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

  void run(int begin, int end, RowSums *sums) {
    for (int y = begin - 2 * kRadius; y < end + 2 * kRadius; y += kGroup) {
      for (int i = 0; i < kGroup; ++i) blur_pictures(y + i);
      // Rows further before the band come out of rows that were never blurred; nothing reads them.
      const int middle = y - kRadius, last = y - 2 * kRadius;
      double ssim[kGroup];
      differentiate_ssim(middle, ssim);
      for (int i = 0; i < kGroup; ++i) {
        if (middle + i >= begin && middle + i < end) sums[middle + i].ssim = ssim[i];
      }
      if (last >= begin) write_gradient(last, std::min(kGroup, end - last), sums);
    }
  }

 private:
  enum Blurred { kImage, kTarget, kSquares, kProduct, kBlurred };             // of the first ring
  enum Derivative { kByMean, kBySquares, kByProduct, kDerivatives };         // of the second
  static constexpr int kScratchRows = std::max<int>(kBlurred, kGroup * kDerivatives);

  bool inside(int y) const { return y >= 0 && y < p_.height; }

  float *scratch(int i) { return rows_ + static_cast<size_t>(i) * layout_.stride + 16; }

  void blur_pictures(int y) {
    if (!inside(y)) return blurred_.clear(y);
    const size_t row = static_cast<size_t>(y) * p_.width;
    float *const image = scratch(0), *const target = scratch(1);
    float *const squares = scratch(2), *const product = scratch(3);
    for (int x = 0; x < layout_.padded; x += kLanes) {
      const int lanes = std::min(kLanes, p_.width - x);
      const Vec a = load_lanes(p_.image + row + x, lanes), b = load_lanes(p_.target + row + x, lanes);
      store(image + x, a);
      store(target + x, b);
      store(squares + x, a * a + b * b);
      store(product + x, a * b);
    }
    blur_row(image, blurred_.row(kImage, y), layout_);
    blur_row(target, blurred_.row(kTarget, y), layout_);
    blur_row(squares, blurred_.row(kSquares, y), layout_);
    blur_row(product, blurred_.row(kProduct, y), layout_);
  }

  // SSIM of rows y .. y + kGroup - 1, each summed; its derivatives by the blurred picture, squares (twice that) and
  // product go to the ring.
  void differentiate_ssim(int y, double *sums) {
    const Ring<kBlurred>::Columns image(blurred_, kImage, y), target(blurred_, kTarget, y),
        squares(blurred_, kSquares, y), product(blurred_, kProduct, y);
    Vec totals[kGroup] = {};
    const auto vector = [&](int x, auto in_picture) {
      Vec mean_1[kGroup], mean_2[kGroup], mean_squares[kGroup], mean_product[kGroup];
      image.at(x, mean_1);
      target.at(x, mean_2);
      squares.at(x, mean_squares);
      product.at(x, mean_product);
      for (int i = 0; i < kGroup; ++i) {
        const Vec m1 = mean_1[i], m2 = mean_2[i], both_means = m1 * m2, means = m1 * m1 + m2 * m2;
        const Vec a1 = 2.0f * both_means + kC1, a2 = 2.0f * (mean_product[i] - both_means) + kC2;
        const Vec b1 = means + kC1, b2 = (mean_squares[i] - means) + kC2;
        const Vec inverse = reciprocal(b1 * b2), scaled = (2.0f * p_.ssim_scale) * inverse;
        const Vec ssim = in_picture(a1 * a2 * inverse);
        totals[i] += ssim;
        store(derivative(i, kByMean) + x, in_picture(scaled * (m2 * (a2 - a1) + m1 * (ssim * (b1 - b2)))));
        store(derivative(i, kBySquares) + x, in_picture(-scaled * (ssim * b1)));
        store(derivative(i, kByProduct) + x, in_picture(scaled * a1));
      }
    };
    const int whole = p_.width / kLanes * kLanes;
    for (int x = 0; x < whole; x += kLanes) vector(x, [](Vec v) { return v; });
    if (whole < p_.width) {
      const Mask within = greater(broadcast(static_cast<float>(p_.width - whole)), lane_numbers());
      vector(whole, [&](Vec v) { return keep(within, v); });
    }
    for (int i = 0; i < kGroup; ++i) {
      if (!inside(y + i)) {
        derivatives_.clear(y + i);
        continue;
      }
      for (int d = 0; d < kDerivatives; ++d) blur_row(derivative(i, d), derivatives_.row(d, y + i), layout_);
    }
    for (int i = 0; i < kGroup; ++i) sums[i] = inside(y + i) ? sum(totals[i]) : 0.0;
  }

  float *derivative(int row_of_group, int which) { return scratch(row_of_group * kDerivatives + which); }

  // The gradient of `count` rows from y, and the sums of their absolute differences.
  void write_gradient(int y, int count, RowSums *sums) {
    const Ring<kDerivatives>::Columns by_mean(derivatives_, kByMean, y), by_squares(derivatives_, kBySquares, y),
        by_product(derivatives_, kByProduct, y);
    const Vec zero{};
    Vec totals[kGroup] = {};
    const auto vector = [&](int x, int rows, int lanes) __attribute__((always_inline)) {
      Vec mean[kGroup], squares[kGroup], product[kGroup];
      by_mean.at(x, mean);
      by_squares.at(x, squares);
      by_product.at(x, product);
      for (int i = 0; i < rows; ++i) {
        const size_t pixel = static_cast<size_t>(y + i) * p_.width + x;
        const Vec a = load_lanes(p_.image + pixel, lanes), b = load_lanes(p_.target + pixel, lanes);
        const Vec difference = a - b;
        const Vec sign = keep(greater(difference, zero), broadcast(p_.l1_scale)) -
                         keep(greater(zero, difference), broadcast(p_.l1_scale));
        totals[i] += abs(difference);
        store_lanes(p_.gradient + pixel, (mean[i] + sign) + (a * squares[i] + b * product[i]), lanes);
      }
    };
    const int whole = p_.width / kLanes * kLanes;
    if (count == kGroup) {
      for (int x = 0; x < whole; x += kLanes) vector(x, kGroup, kLanes);
    } else {
      for (int x = 0; x < whole; x += kLanes) vector(x, count, kLanes);
    }
    if (whole < p_.width) vector(whole, count, p_.width - whole);
    for (int i = 0; i < count; ++i) sums[y + i].l1 = sum(totals[i]);
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
    // A whole number of groups, so that every row has the same place in a group however many threads there are.
    const int share = (height + threads - 1) / threads;
    const int band_rows = std::max(kLeastBandRows, (share + kGroup - 1) / kGroup * kGroup);
    const int bands = (height + band_rows - 1) / band_rows;
    const size_t plane = static_cast<size_t>(width) * height;
    const double values = 3.0 * static_cast<double>(plane);
    std::vector<RowSums> sums(3 * static_cast<size_t>(height));
    parallel_for(threads, 3 * bands, 1, [&](int64_t unit) {
      const int64_t channel_number = unit / bands;
      const size_t channel = plane * channel_number;
      const int begin = static_cast<int>(unit % bands) * band_rows;
      const LossParameters p{image + channel,
                             target + channel,
                             gradient + channel,
                             width,
                             height,
                             static_cast<float>((1.0 - dssim_weight) / values),
                             static_cast<float>(-dssim_weight / values)};
      static thread_local Buffer<float> memory;
      Band band(p, memory.reserve(Band::memory_size(width)));
      band.run(begin, std::min(height, begin + band_rows), sums.data() + channel_number * height);
    });
    double l1 = 0, ssim = 0;
    for (const RowSums &s : sums) {
      l1 += s.l1;
      ssim += s.ssim;
    }
    *loss = (1.0 - dssim_weight) * l1 / values + dssim_weight * (1.0 - ssim / values);
    return HGS_OK;
  });
}
