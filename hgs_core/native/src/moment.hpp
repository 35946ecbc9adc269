// Static and dynamic splats at one moment (docs/numerics.md, "Time"), kLanes rows at a time.
#pragma once

#include "projection.hpp"

namespace hgs {

// Up to kLanes rows of the parameter arrays; the last is repeated to fill the lanes.
struct Rows {
  uint32_t row[kLanes];
  int count;

  template <class RowAt>
  Rows(int n, RowAt row_at) : count(n) {
    for (int k = 0; k < kLanes; ++k) row[k] = row_at(k < n ? k : n - 1);
  }
};

// Read rows of an array with `width` columns, one column per vector.
template <int width>
inline void gather(const float *array, const Rows &rows, Vec *out) {
  alignas(64) float columns[width][kLanes];
  for (int k = 0; k < kLanes; ++k) {
    const float *from = array + static_cast<size_t>(rows.row[k]) * width;
    for (int c = 0; c < width; ++c) columns[c][k] = from[c];
  }
  for (int c = 0; c < width; ++c) out[c] = load(columns[c]);
}

// Remembers whether it has seen a value that is refused (docs/numerics.md, "What is refused").
class Refusal {
 public:
  template <int width>
  void look_at(const Vec *values) {
    for (int c = 0; c < width; ++c) sum_ += values[c] * 0.0f;
  }
  template <int width>
  void look_at_colours(const Vec *values) {
    look_at<width>(values);
    for (int c = 0; c < width; ++c) largest_ = max(abs(values[c]), largest_);
  }

  // Rows [begin, end) of an array.
  template <int width>
  void look_at(const float *array, int64_t begin, int64_t end) {
    each_vector(array, begin * width, end * width, [&](Vec v) { look_at<1>(&v); });
  }
  template <int width>
  void look_at_colours(const float *array, int64_t begin, int64_t end) {
    each_vector(array, begin * width, end * width, [&](Vec v) { look_at_colours<1>(&v); });
  }

  bool found() const {
    return lane_bits(greater_equal(sum_, Vec{})) != kAllLanes || any(greater(largest_, broadcast(kColourMax)));
  }

 private:
  static constexpr uint32_t kAllLanes = (1u << kLanes) - 1;

  template <class F>
  static void each_vector(const float *array, int64_t begin, int64_t end, F &&f) {
    for (; end - begin >= kLanes; begin += kLanes) f(load_unaligned(array + begin));
    if (end > begin) f(load_lanes(array + begin, static_cast<int>(end - begin)));
  }

  Vec sum_{};      // NaN in the lanes of values that are not finite: zero times any other is zero
  Vec largest_{};  // magnitude of a colour
};

// Write rows, unless nobody wants the array.
template <int width>
inline void scatter(float *array, const Rows &rows, const Vec *values) {
  if (array == nullptr) return;
  alignas(64) float columns[width][kLanes];
  for (int c = 0; c < width; ++c) store(columns[c], values[c]);
  for (int k = 0; k < rows.count; ++k) {
    float *to = array + static_cast<size_t>(rows.row[k]) * width;
    for (int c = 0; c < width; ++c) to[c] = columns[c][k];
  }
}

inline Vec sigmoid(Vec x) { return 1.0f / (1.0f + exp(-x)); }

// Both kinds of splats offer the same to projection: `opacity` alone, because most dynamic splats are dead at any time
// and are left out on its account, then the shape; and the way back. `refusal` looks at every static splat beforehand, and
// of dynamics at what is read.
struct StaticMoment {
  const hgs_static_splats &splats;

  int64_t count() const { return splats.count; }

  void look_at_all(int64_t begin, int64_t end, Refusal &refusal) const {
    refusal.look_at<3>(splats.means, begin, end);
    refusal.look_at<3>(splats.log_scales, begin, end);
    refusal.look_at<4>(splats.quats, begin, end);
    refusal.look_at<1>(splats.opacity_logits, begin, end);
    refusal.look_at_colours<3>(splats.rgb, begin, end);
  }

  Vec opacity(const Rows &rows, Refusal &) const {
    Vec logit;
    gather<1>(splats.opacity_logits, rows, &logit);
    return sigmoid(logit);
  }

  Shape shape(const Rows &rows, Refusal &) const {
    Shape s;
    Vec mean[3], quat[4];
    gather<3>(splats.means, rows, mean);
    gather<3>(splats.log_scales, rows, s.log_scale);
    gather<4>(splats.quats, rows, quat);
    gather<3>(splats.rgb, rows, s.rgb);
    for (int i = 0; i < 3; ++i) s.mean[i] = widen(mean[i]);
    for (int i = 0; i < 4; ++i) s.quat[i] = widen(quat[i]);
    return s;
  }

  void backward(const Rows &rows, const ShapeGradient &d_shape, Vec d_opacity, const Vec *d_rgb,
                const hgs_static_gradients &out) const {
    Refusal ignored;  // the forward pass has looked
    const Vec sigma = opacity(rows, ignored), d_logit = d_opacity * sigma * (1.0f - sigma);
    scatter<3>(out.means, rows, d_shape.mean);
    scatter<3>(out.log_scales, rows, d_shape.log_scale);
    scatter<4>(out.quats, rows, d_shape.quat);
    scatter<1>(out.opacity_logits, rows, &d_logit);
    scatter<3>(out.rgb, rows, d_rgb);
  }
};

// Of a set whose motion has so many coefficients: constant, so that loops over them are unrolled.
template <int kCoefficients>
struct DynamicMoment {
  static constexpr int kMotion = 3 * kCoefficients;

  const hgs_dynamic_splats &splats;
  double time;

  int64_t count() const { return splats.count; }

  void look_at_all(int64_t, int64_t, Refusal &) const {}

  Vec opacity(const Rows &rows, Refusal &refusal) const {
    const Fade f = fade(rows, refusal);
    return f.sigma * f.decay;
  }

  Shape shape(const Rows &rows, Refusal &refusal) const {
    Shape s;
    Vec center, motion[kMotion], rotation[8];
    gather<1>(splats.time_centers, rows, &center);
    gather<kMotion>(splats.motion, rows, motion);
    gather<8>(splats.rotation, rows, rotation);
    gather<3>(splats.log_scales, rows, s.log_scale);
    gather<3>(splats.rgb, rows, s.rgb);
    refusal.look_at<kMotion>(motion);
    refusal.look_at<8>(rotation);
    refusal.look_at<3>(s.log_scale);
    refusal.look_at_colours<3>(s.rgb);
    const Wide d = offset(center);
    for (int i = 0; i < 3; ++i) {
      s.mean[i] = widen(motion[kMotion - 3 + i]);
      for (int k = kCoefficients - 2; k >= 0; --k) s.mean[i] = widen(motion[3 * k + i]) + d * s.mean[i];
    }
    for (int i = 0; i < 4; ++i) s.quat[i] = widen(rotation[i]) + d * widen(rotation[4 + i]);
    return s;
  }

  void backward(const Rows &rows, const ShapeGradient &d_shape, Vec d_opacity, const Vec *d_rgb,
                const hgs_dynamic_gradients &out) const {
    Refusal ignored;  // the forward pass has looked
    const Fade f = fade(rows, ignored);
    const Vec d = f.offset, opacity = f.sigma * f.decay;
    Vec motion[kMotion], rotation[8], d_motion[kMotion], d_rotation[8];
    gather<kMotion>(splats.motion, rows, motion);
    gather<8>(splats.rotation, rows, rotation);
    // o = sigma exp(-s d^2), so d ln o / d d = -2 s d and d ln o / d ln s = -s d^2.
    const Vec d_log_precision = -d_opacity * opacity * f.precision * d * d;
    Vec d_offset = -2.0f * d_opacity * opacity * f.precision * d;
    for (int i = 0; i < 3; ++i) {
      constexpr int kLast = kCoefficients - 1;
      constexpr float kOrder = kLast;
      Vec velocity = (kOrder - 1.0f) * motion[3 * (kLast - 1) + i] + kOrder * d * motion[3 * kLast + i];
      for (int k = kLast - 2; k >= 1; --k) velocity = static_cast<float>(k) * motion[3 * k + i] + d * velocity;
      d_offset += d_shape.mean[i] * velocity;
      d_motion[i] = d_shape.mean[i];
      for (int k = 1; k < kCoefficients; ++k) d_motion[3 * k + i] = d * d_motion[3 * (k - 1) + i];
    }
    for (int i = 0; i < 4; ++i) {
      d_offset += d_shape.quat[i] * rotation[4 + i];
      d_rotation[i] = d_shape.quat[i];
      d_rotation[4 + i] = d * d_shape.quat[i];
    }
    const Vec d_center = -d_offset, d_logit = d_opacity * opacity * (1.0f - f.sigma);
    scatter<kMotion>(out.motion, rows, d_motion);
    scatter<8>(out.rotation, rows, d_rotation);
    scatter<3>(out.log_scales, rows, d_shape.log_scale);
    scatter<1>(out.opacity_logits, rows, &d_logit);
    scatter<1>(out.time_centers, rows, &d_center);
    scatter<1>(out.time_log_precisions, rows, &d_log_precision);
    scatter<3>(out.rgb, rows, d_rgb);
  }

 private:
  struct Fade {
    Vec offset, precision, sigma, decay;
  };

  Wide offset(Vec center) const { return broadcast_wide(time) - widen(center); }

  Fade fade(const Rows &rows, Refusal &refusal) const {
    Vec center, log_precision, logit;
    gather<1>(splats.time_centers, rows, &center);
    gather<1>(splats.time_log_precisions, rows, &log_precision);
    gather<1>(splats.opacity_logits, rows, &logit);
    refusal.look_at<1>(&center);
    refusal.look_at<1>(&log_precision);
    refusal.look_at<1>(&logit);
    const Vec d = narrow(offset(center)), s = exp(log_precision);
    return {d, s, sigmoid(logit), exp(-s * d * d)};
  }
};

// Call `with` with the moment of a dynamic set and return what it returns.
template <class F>
inline auto with_moment(const hgs_dynamic_splats &splats, double time, F &&with) {
  return splats.coefficients == 6 ? with(DynamicMoment<6>{splats, time}) : with(DynamicMoment<4>{splats, time});
}

}  // namespace hgs
