// Which pixels of a range the visible ellipse of a splat can change.
#pragma once

#include <algorithm>
#include <cmath>

#include "screen.hpp"
#include "simd.hpp"

namespace hgs {

// For V = float one ellipse, for V = Vec one in every lane.
//
// t^2 + e^2 <= log2_opacity - kLog2AlphaMin about the mean of a splat (screen.hpp).
template <class V>
class Ellipse {
 public:
  // Pixels, inclusive, in whole numbers.
  struct Range {
    V x0, x1, y0, y1;
  };

  // `s` has the members of ScreenSplat that are named here.
  template <class Splat>
  explicit Ellipse(const Splat &s)
      : origin_x_(s.origin_x),
        origin_y_(s.origin_y),
        mean_x_(s.mean_x),
        mean_y_(s.mean_y),
        reach_(max(s.log2_opacity - kLog2AlphaMin, V{})),
        fall_y_(s.scale_e * s.scale_e) {
    const V t_by_y = s.scale_t * s.slope;
    const V inverse_yy = 1.0f / (t_by_y * t_by_y + fall_y_);
    inverse_x_ = 1.0f / s.scale_t;
    fall_x_ = fall_y_ * inverse_yy * s.scale_t * s.scale_t;
    slope_x_ = -s.slope;
    slope_y_ = -s.scale_t * t_by_y * inverse_yy;
    inverse_y_ = sqrt(inverse_yy);
    dy_of_right_ = slope_y_ * sqrt(reach_ / fall_x_);
    dx_of_bottom_ = slope_x_ * sqrt(reach_ / fall_y_);
  }

  // The pixels of `r` narrowed in x to what the ellipse covers of its rows; x1 < x0 where that is none.
  Range narrow_x(const Range &r) const {
    const V top = offset(r.y0, origin_y_, mean_y_), bottom = offset(r.y1, origin_y_, mean_y_);
    const V right = limit(dy_of_right_, top, bottom), left = limit(-dy_of_right_, top, bottom);
    const V low = slope_x_ * left - inverse_x_ * half_chord(fall_y_, left);
    const V high = slope_x_ * right + inverse_x_ * half_chord(fall_y_, right);
    return {first(low + mean_x_, origin_x_, r.x0, r.x1), last(high + mean_x_, origin_x_, r.x0, r.x1), r.y0, r.y1};
  }

  // The same in y for its columns.
  Range narrow_y(const Range &r) const {
    const V left = offset(r.x0, origin_x_, mean_x_), right = offset(r.x1, origin_x_, mean_x_);
    const V bottom = limit(dx_of_bottom_, left, right), top = limit(-dx_of_bottom_, left, right);
    const V low = slope_y_ * top - inverse_y_ * half_chord(fall_x_, top);
    const V high = slope_y_ * bottom + inverse_y_ * half_chord(fall_x_, bottom);
    return {r.x0, r.x1, first(low + mean_y_, origin_y_, r.y0, r.y1), last(high + mean_y_, origin_y_, r.y0, r.y1)};
  }

 private:
  // NaN comes out as a limit.
  static float max(float a, float b) { return a > b ? a : b; }
  static float min(float a, float b) { return a < b ? a : b; }
  static float sqrt(float x) { return std::sqrt(x); }
  static float ceil(float x) { return std::ceil(x); }
  static float floor(float x) { return std::floor(x); }
  static Vec max(Vec a, Vec b) { return hgs::max(a, b); }
  static Vec min(Vec a, Vec b) { return hgs::min(a, b); }
  static Vec sqrt(Vec x) { return hgs::sqrt(x); }
  static Vec ceil(Vec x) { return hgs::ceil(x); }
  static Vec floor(Vec x) { return hgs::floor(x); }
  static V limit(V x, V low, V high) { return min(max(x, low), high); }

  // Of a pixel's centre from the mean.
  static V offset(V pixel, V origin, V mean) { return (pixel - origin) + 0.5f - mean; }

  V half_chord(V fall, V d) const { return sqrt(max(reach_ - fall * d * d, V{})); }

  // The first and the last pixel of [from, to] whose centre lies above `edge` and below it.
  static V first(V edge, V origin, V from, V to) {
    return limit(ceil(edge - 0.5f - kPixelSlack) + origin, from, to + 1.0f);
  }
  static V last(V edge, V origin, V from, V to) {
    return limit(floor(edge - 0.5f + kPixelSlack) + origin, from - 1.0f, to);
  }

  V origin_x_, origin_y_, mean_x_, mean_y_;
  V reach_;
  V fall_x_, fall_y_;      // what is left of `reach_` at an offset along one axis, for the chord along the other
  V slope_x_, slope_y_;    // the chords' middles lie at dx = slope_x dy and dy = slope_y dx
  V inverse_x_, inverse_y_;
  V dy_of_right_, dx_of_bottom_;  // where the ellipse's extreme points lie
};

}  // namespace hgs
