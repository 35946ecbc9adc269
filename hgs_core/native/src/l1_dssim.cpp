// L1 + D-SSIM (Wang et al. 2004) and its gradient, fused.
//
// SSIM is that of the windows around every second pixel of every third row, which differ little from those between. A band
// of rows streams through four stages, a few rows of windows at a time, so that everything in between stays in the cache:
//     the pictures and their products, blurred along the columns, at every third row
//     the same blurred along the rows, at every second column -> SSIM and its partial derivatives
//     the derivatives, blurred along the rows to all columns
//     the same blurred along the columns to all rows -> the gradient
// Outside the picture everything is zero, as in a convolution with zero padding.
#include <algorithm>
#include <vector>

#include "api.hpp"
#include "buffer.hpp"
#include "gaussian_window.hpp"
#include "lanes.hpp"
#include "thread_pool.hpp"

namespace hgs {
namespace {

constexpr int kStep = 3;                      // rows of the picture from one row of windows to the next
constexpr int kGroup = kLanes == 16 ? 4 : 2;  // rows of windows at a time: as many as there are registers for
constexpr int kLeastBandRows = 72;            // a band computes 10 rows of its neighbours, too
constexpr int kMargin = 16;                   // zeros on either side of a row, for the taps that reach out

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
        padded_(padded(p.width)),
        stride_(stride(p.width)),
        ring_(memory),
        scratch_(memory + kRing * kPlanes * stride_) {
    std::fill_n(memory, memory_size(p.width), 0.0f);
  }

  static size_t memory_size(int width) { return (kRing * kPlanes + kScratchRows + 1) * stride(width); }

  // Rows [begin, end) of the picture; begin is a multiple of kStep.
  void run(int begin, int end, RowSums *sums) {
    int written = begin;  // rows before it
    for (int window = begin / kStep - 1; written < end; window += kGroup) {
      double ssim[kGroup];
      blur_pictures(window);
      for (int i = 0; i < kGroup; ++i) ssim[i] = differentiate_ssim(window + i, i);
      for (int i = 0; i < kGroup; ++i) {
        const int y = kStep * (window + i);
        if (y >= begin && y < end) sums[y].ssim = ssim[i];
      }
      for (; written / kStep + 2 < window + kGroup && written < end; written += kStep) {
        write_gradient(written, std::min(kStep, end - written), sums);
      }
    }
  }

 private:
  enum Quantity { kImage, kTarget, kSquares, kProduct, kQuantities };
  enum Derivative { kByMean, kBySquares, kByProduct, kPlanes };  // by the blurred picture, squares (twice that), product
  static constexpr int kAround = 4;                 // rows of windows that a row of the picture, or the next two, lie in
  static constexpr int kRing = kGroup + kAround - 1;
  static constexpr int kInputRows = kStep * (kGroup - 1) + 1 + 2 * kRadius;
  static constexpr int kScratchRows = 2 * kGroup * kQuantities + kPlanes;

  static size_t padded(int width) { return (width + 2 * kLanes - 1) / (2 * kLanes) * (2 * kLanes); }
  static size_t stride(int width) { return padded(width) + 2 * kMargin; }

  // Of columns of even and of odd number, and of derivatives at the windows; rows of half the length.
  float *blurred(int of_group, int quantity, int odd) {
    return scratch_ + ((of_group * kQuantities + quantity) * 2 + odd) * stride_ + kMargin;
  }
  float *derivative(int plane) { return scratch_ + (2 * kGroup * kQuantities + plane) * stride_ + kMargin; }
  const float *zeros() const { return scratch_ + kScratchRows * stride_; }
  float *ring_row(int plane, int window) {
    return ring_ + ((window + 2 * kRing) % kRing * kPlanes + plane) * stride_;
  }

  // Rows `window` and those after it of all four quantities, blurred along the columns.
  void blur_pictures(int window) {
    const float *images[kInputRows], *targets[kInputRows];
    for (int t = 0; t < kInputRows; ++t) {
      const int y = kStep * window - kRadius + t;
      const bool inside = y >= 0 && y < p_.height;
      images[t] = inside ? p_.image + static_cast<size_t>(y) * p_.width : zeros();
      targets[t] = inside ? p_.target + static_cast<size_t>(y) * p_.width : zeros();
    }
    // The rows that the next call will be the first to read, which the processor does not foresee.
    const int ahead = std::clamp(kStep * window - kRadius + kInputRows, 0, p_.height - 1);
    const int ahead_count = std::min(kStep * kGroup, p_.height - ahead);
    const auto columns = [&](int x, int lanes, Vec (&sums)[kGroup][kQuantities]) __attribute__((always_inline)) {
#pragma GCC unroll 32
      for (int t = 0; t < kInputRows; ++t) {
        const Vec a = load_lanes(images[t] + x, lanes), b = load_lanes(targets[t] + x, lanes);
        const Vec values[] = {a, b, a * a + b * b, a * b};
#pragma GCC unroll 4
        for (int i = 0; i < kGroup; ++i) {
          const int tap = t - kStep * i - kRadius;
          if (tap < -kRadius || tap > kRadius) continue;
          for (int q = 0; q < kQuantities; ++q) {
            const Vec part = kGaussian[tap < 0 ? -tap : tap] * values[q];
            sums[i][q] = tap == -kRadius ? part : sums[i][q] + part;
          }
        }
      }
    };
    const auto two_vectors = [&](int x, int lanes, int more_lanes) __attribute__((always_inline)) {
      for (int t = 0; t < ahead_count; ++t) {
        for (int k = 0; k < 2 * kLanes; k += 16) {
          const size_t pixel = static_cast<size_t>(ahead + t) * p_.width + x + k;
          __builtin_prefetch(p_.image + pixel, 0, 2);
          __builtin_prefetch(p_.target + pixel, 0, 2);
        }
      }
      Vec first[kGroup][kQuantities], second[kGroup][kQuantities];
      columns(x, lanes, first);
      columns(x + kLanes, more_lanes, second);
      for (int i = 0; i < kGroup; ++i) {
        for (int q = 0; q < kQuantities; ++q) {
          Vec even, odd;
          split(first[i][q], second[i][q], even, odd);
          store(blurred(i, q, 0) + x / 2, even);
          store(blurred(i, q, 1) + x / 2, odd);
        }
      }
    };
    const int whole = p_.width / (2 * kLanes) * (2 * kLanes), rest = p_.width - whole;
    for (int x = 0; x < whole; x += 2 * kLanes) two_vectors(x, kLanes, kLanes);
    if (rest > 0) two_vectors(whole, std::min(rest, kLanes), std::max(rest - kLanes, 0));
  }

  // The sum of SSIM over a row of windows; its derivatives, blurred along the row, go to the ring.
  double differentiate_ssim(int window, int of_group) {
    if (window < 0 || kStep * window >= p_.height) {
      for (int d = 0; d < kPlanes; ++d) std::fill_n(ring_row(d, window), padded_, 0.0f);
      return 0.0;
    }
    const int windows = (p_.width + 1) / 2;
    Vec total{};
    const auto vector = [&](int x, auto in_picture) __attribute__((always_inline)) {
      Vec mean[kQuantities];
      for (int q = 0; q < kQuantities; ++q) {
        const float *const even = blurred(of_group, q, 0) + x, *const odd = blurred(of_group, q, 1) + x;
        const auto at = [](const float *p, int i) { return load_unaligned(p + i); };
        mean[q] = (kGaussian[0] * load(even) + kGaussian[1] * (at(odd, -1) + load(odd))) +
                  (kGaussian[2] * (at(even, -1) + at(even, 1)) + kGaussian[3] * (at(odd, -2) + at(odd, 1))) +
                  (kGaussian[4] * (at(even, -2) + at(even, 2)) + kGaussian[5] * (at(odd, -3) + at(odd, 2)));
      }
      const Vec m1 = mean[kImage], m2 = mean[kTarget], both_means = m1 * m2, means = m1 * m1 + m2 * m2;
      const Vec a1 = 2.0f * both_means + kC1, a2 = 2.0f * (mean[kProduct] - both_means) + kC2;
      const Vec b1 = means + kC1, b2 = (mean[kSquares] - means) + kC2;
      const Vec inverse = reciprocal(b1 * b2), scaled = (2.0f * p_.ssim_scale) * inverse;
      const Vec ssim = in_picture(a1 * a2 * inverse);
      total += ssim;
      store(derivative(kByMean) + x, in_picture(scaled * (m2 * (a2 - a1) + m1 * (ssim * (b1 - b2)))));
      store(derivative(kBySquares) + x, in_picture(-scaled * (ssim * b1)));
      store(derivative(kByProduct) + x, in_picture(scaled * a1));
    };
    const int whole = windows / kLanes * kLanes;
    for (int x = 0; x < whole; x += kLanes) vector(x, [](Vec v) { return v; });
    if (whole < windows) {
      const Mask within = greater(broadcast(static_cast<float>(windows - whole)), lane_numbers());
      vector(whole, [&](Vec v) { return keep(within, v); });
    }
    for (int d = 0; d < kPlanes; ++d) blur_to_all_columns(derivative(d), ring_row(d, window));
    return sum(total);
  }

  void blur_to_all_columns(const float *in, float *out) const {
    for (size_t x = 0; x < padded_; x += 2 * kLanes, in += kLanes) {
      const Vec before2 = load_unaligned(in - 2), before = load_unaligned(in - 1), here = load(in);
      const Vec after = load_unaligned(in + 1), after2 = load_unaligned(in + 2), after3 = load_unaligned(in + 3);
      const Vec even = kGaussian[0] * here + (kGaussian[2] * (before + after) + kGaussian[4] * (before2 + after2));
      const Vec odd = kGaussian[1] * (here + after) + (kGaussian[3] * (before + after2) + kGaussian[5] * (before2 + after3));
      Vec first, second;
      interleave(even, odd, first, second);
      store(out + x, first);
      store(out + x + kLanes, second);
    }
  }

  // The gradient of `count` rows from y, a multiple of kStep, and the sums of their absolute differences.
  void write_gradient(int y, int count, RowSums *sums) {
    const float *rows[kPlanes][kAround];
    for (int d = 0; d < kPlanes; ++d) {
      for (int t = 0; t < kAround; ++t) rows[d][t] = ring_row(d, y / kStep - 1 + t);
    }
    Vec totals[kStep] = {};
    const auto vector = [&](int x, int lanes) __attribute__((always_inline)) {
      Vec by[kStep][kPlanes];
      for (int d = 0; d < kPlanes; ++d) {
        const Vec before = load(rows[d][0] + x), here = load(rows[d][1] + x);
        const Vec after = load(rows[d][2] + x), after2 = load(rows[d][3] + x);
        by[0][d] = kGaussian[0] * here + kGaussian[3] * (before + after);
        by[1][d] = (kGaussian[1] * here + kGaussian[2] * after) + (kGaussian[4] * before + kGaussian[5] * after2);
        by[2][d] = (kGaussian[2] * here + kGaussian[1] * after) + (kGaussian[5] * before + kGaussian[4] * after2);
      }
      for (int i = 0; i < count; ++i) {
        const size_t pixel = static_cast<size_t>(y + i) * p_.width + x;
        const Vec a = load_lanes(p_.image + pixel, lanes), b = load_lanes(p_.target + pixel, lanes);
        const Vec difference = a - b, zero{};
        const Vec sign = keep(greater(difference, zero), broadcast(p_.l1_scale)) -
                         keep(greater(zero, difference), broadcast(p_.l1_scale));
        totals[i] += abs(difference);
        const Vec gradient = (by[i][kByMean] + sign) + (a * by[i][kBySquares] + b * by[i][kByProduct]);
        store_lanes(p_.gradient + pixel, gradient, lanes);
      }
    };
    const int whole = p_.width / kLanes * kLanes;
    for (int x = 0; x < whole; x += kLanes) vector(x, kLanes);
    if (whole < p_.width) vector(whole, p_.width - whole);
    for (int i = 0; i < count; ++i) sums[y + i].l1 = sum(totals[i]);
  }

  const LossParameters p_;
  const size_t padded_, stride_;
  float *const ring_, *const scratch_;
};

}  // namespace
}  // namespace hgs

extern "C" int32_t hgs_l1_dssim(const float *image, const float *target, int32_t width, int32_t height,
                                float dssim_weight, int32_t threads, double *loss, float *gradient) {
  using namespace hgs;
  return guarded([&] {
    constexpr int kBand = kStep * kGroup;
    const int share = (height + threads - 1) / threads;
    // A whole number of groups, so that every row has the same place in a group however many threads there are.
    const int band_rows = std::max(kLeastBandRows, (share + kBand - 1) / kBand * kBand);
    const int bands = (height + band_rows - 1) / band_rows;
    const size_t plane = static_cast<size_t>(width) * height;
    const double values = 3.0 * static_cast<double>(plane);
    const double windows = 3.0 * ((width + 1) / 2) * ((height + kStep - 1) / kStep);
    std::vector<RowSums> sums(3 * static_cast<size_t>(height));
    parallel_for(threads, 3 * bands, 1, [&](int64_t unit) {
      const int64_t channel_number = unit / bands;
      const size_t channel = plane * channel_number;
      const int begin = static_cast<int>(unit % bands) * band_rows;
      const LossParameters p{image + channel, target + channel, gradient + channel, width, height,
                             static_cast<float>((1.0 - dssim_weight) / values), static_cast<float>(-dssim_weight / windows)};
      static thread_local Buffer<float> memory;
      Band band(p, memory.reserve(Band::memory_size(width)));
      band.run(begin, std::min(height, begin + band_rows), sums.data() + channel_number * height);
    });
    double l1 = 0, ssim = 0;
    for (const RowSums &s : sums) {
      l1 += s.l1;
      ssim += s.ssim;
    }
    *loss = (1.0 - dssim_weight) * l1 / values + dssim_weight * (1.0 - ssim / windows);
    return HGS_OK;
  });
}
