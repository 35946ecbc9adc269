// The mean structural similarity of two pictures (Wang et al. 2004), around every pixel: the measure, not the loss.
//
// The picture is cut into bands of rows. A band streams through two stages, four rows at a time, so that everything in
// between stays in the cache:
//     rows y .. y + 3        the pictures and their products, blurred along the row
//     rows y - 5 .. y - 2    the same blurred along the column -> SSIM
// Four rows of a column share 14 rows of input, where one alone reads 11. Outside the picture everything is zero, as in a
// convolution with zero padding.
#include <algorithm>
#include <vector>

#include "api.hpp"
#include "buffer.hpp"
#include "gaussian_window.hpp"
#include "lanes.hpp"
#include "thread_pool.hpp"

namespace hgs {
namespace {

constexpr int kLeastBandRows = 64;  // a band computes 10 rows of its neighbours, too
constexpr int kGroup = 4;           // rows

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

class Band {
 public:
  // image, target: one channel.
  Band(const float *image, const float *target, int width, int height, float *memory)
      : image_(image),
        target_(target),
        width_(width),
        height_(height),
        layout_(width),
        blurred_(memory, layout_),
        rows_(memory + Ring<kQuantities>::size(layout_)) {
    std::fill_n(rows_, static_cast<size_t>(kQuantities) * layout_.stride, 0.0f);
  }

  static size_t memory_size(int width) {
    const RowLayout layout(width);
    return Ring<kQuantities>::size(layout) + static_cast<size_t>(kQuantities) * layout.stride;
  }

  // The sum of SSIM over each of the rows [begin, end).
  void run(int begin, int end, double *sums) {
    for (int y = begin - kRadius; y < end + kRadius; y += kGroup) {
      for (int i = 0; i < kGroup; ++i) blur_pictures(y + i);
      // Rows before the band come out of rows that were never blurred; nothing reads them.
      double ssim[kGroup];
      const int middle = y - kRadius;
      sum_ssim(middle, ssim);
      for (int i = 0; i < kGroup; ++i) {
        if (middle + i >= begin && middle + i < end) sums[middle + i] = ssim[i];
      }
    }
  }

 private:
  enum Quantity { kImage, kTarget, kSquares, kProduct, kQuantities };

  float *scratch(int i) { return rows_ + static_cast<size_t>(i) * layout_.stride + 16; }

  void blur_pictures(int y) {
    if (y < 0 || y >= height_) return blurred_.clear(y);
    const size_t row = static_cast<size_t>(y) * width_;
    float *const image = scratch(0), *const target = scratch(1);
    float *const squares = scratch(2), *const product = scratch(3);
    for (int x = 0; x < layout_.padded; x += kLanes) {
      const int lanes = std::min(kLanes, width_ - x);
      const Vec a = load_lanes(image_ + row + x, lanes), b = load_lanes(target_ + row + x, lanes);
      store(image + x, a);
      store(target + x, b);
      store(squares + x, a * a + b * b);
      store(product + x, a * b);
    }
    for (int q = 0; q < kQuantities; ++q) blur_row(scratch(q), blurred_.row(q, y), layout_);
  }

  void sum_ssim(int y, double *sums) {
    const Ring<kQuantities>::Columns image(blurred_, kImage, y), target(blurred_, kTarget, y),
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
        totals[i] += in_picture(a1 * a2 * reciprocal(b1 * b2));
      }
    };
    const int whole = width_ / kLanes * kLanes;
    for (int x = 0; x < whole; x += kLanes) vector(x, [](Vec v) { return v; });
    if (whole < width_) {
      const Mask within = greater(broadcast(static_cast<float>(width_ - whole)), lane_numbers());
      vector(whole, [&](Vec v) { return keep(within, v); });
    }
    for (int i = 0; i < kGroup; ++i) sums[i] = sum(totals[i]);
  }

  const float *image_, *target_;
  int width_, height_;
  RowLayout layout_;
  Ring<kQuantities> blurred_;
  float *rows_;
};

}  // namespace
}  // namespace hgs

extern "C" int32_t hgs_ssim(const float *image, const float *target, int32_t width, int32_t height, int32_t threads,
                            double *mean) {
  using namespace hgs;
  return guarded([&] {
    // A whole number of groups, so that every row has the same place in a group however many threads there are.
    const int share = (height + threads - 1) / threads;
    const int band_rows = std::max(kLeastBandRows, (share + kGroup - 1) / kGroup * kGroup);
    const int bands = (height + band_rows - 1) / band_rows;
    const size_t plane = static_cast<size_t>(width) * height;
    std::vector<double> sums(3 * static_cast<size_t>(height));
    parallel_for(threads, 3 * bands, 1, [&](int64_t unit) {
      const size_t channel = unit / bands;
      const int begin = static_cast<int>(unit % bands) * band_rows;
      static thread_local Buffer<float> memory;
      Band band(image + plane * channel, target + plane * channel, width, height, memory.reserve(Band::memory_size(width)));
      band.run(begin, std::min(height, begin + band_rows), sums.data() + channel * height);
    });
    double total = 0;
    for (const double s : sums) total += s;  // in the order of the rows, however they were shared out
    *mean = total / (3.0 * static_cast<double>(plane));
    return HGS_OK;
  });
}
