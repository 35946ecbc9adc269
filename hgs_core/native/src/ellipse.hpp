// Which pixels of a range the visible ellipse of a splat can change.
#pragma once

#include <algorithm>
#include <cmath>

#include "screen.hpp"

namespace hgs {

// t^2 + e^2 <= log2_opacity - kLog2AlphaMin about the mean of a splat (screen.hpp).
class Ellipse {
 public:
  explicit Ellipse(const ScreenSplat &s)
      : origin_x_(s.origin_x),
        origin_y_(s.origin_y),
        mean_x_(s.mean_x),
        mean_y_(s.mean_y),
        reach_(std::max(0.0f, s.log2_opacity - kLog2AlphaMin)),
        fall_y_(s.scale_e * s.scale_e) {
    const float t_by_y = s.scale_t * s.slope;
    const float inverse_yy = 1.0f / (t_by_y * t_by_y + fall_y_);
    inverse_x_ = 1.0f / s.scale_t;
    fall_x_ = fall_y_ * inverse_yy * s.scale_t * s.scale_t;
    slope_x_ = -s.slope;
    slope_y_ = -s.scale_t * t_by_y * inverse_yy;
    inverse_y_ = std::sqrt(inverse_yy);
    dy_of_right_ = slope_y_ * std::sqrt(reach_ / fall_x_);
    dx_of_bottom_ = slope_x_ * std::sqrt(reach_ / fall_y_);
  }

  // The pixels of `r` narrowed in x to what the ellipse covers of its rows.
  PixelRange narrow_x(PixelRange r) const {
    const float top = offset(r.y0, origin_y_, mean_y_), bottom = offset(r.y1, origin_y_, mean_y_);
    const float right = std::clamp(dy_of_right_, top, bottom), left = std::clamp(-dy_of_right_, top, bottom);
    const float low = slope_x_ * left - inverse_x_ * half_chord(fall_y_, left);
    const float high = slope_x_ * right + inverse_x_ * half_chord(fall_y_, right);
    return {first(low + mean_x_, origin_x_, r.x0, r.x1), last(high + mean_x_, origin_x_, r.x0, r.x1), r.y0, r.y1};
  }

  // The same in y for its columns.
  PixelRange narrow_y(PixelRange r) const {
    const float left = offset(r.x0, origin_x_, mean_x_), right = offset(r.x1, origin_x_, mean_x_);
    const float bottom = std::clamp(dx_of_bottom_, left, right), top = std::clamp(-dx_of_bottom_, left, right);
    const float low = slope_y_ * top - inverse_y_ * half_chord(fall_x_, top);
    const float high = slope_y_ * bottom + inverse_y_ * half_chord(fall_x_, bottom);
    return {r.x0, r.x1, first(low + mean_y_, origin_y_, r.y0, r.y1), last(high + mean_y_, origin_y_, r.y0, r.y1)};
  }

 private:
  // Of a pixel's centre from the mean.
  static float offset(int pixel, float origin, float mean) { return (static_cast<float>(pixel) - origin) + 0.5f - mean; }

  float half_chord(float fall, float d) const { return std::sqrt(std::max(0.0f, reach_ - fall * d * d)); }

  // The first and the last pixel of [from, to] whose centre lies above `edge` and below it.
  static int first(float edge, float origin, int from, int to) {
    const float pixel = std::ceil(edge - 0.5f - kPixelSlack) + origin;
    return static_cast<int>(std::clamp(pixel, static_cast<float>(from), to + 1.0f));
  }
  static int last(float edge, float origin, int from, int to) {
    const float pixel = std::floor(edge - 0.5f + kPixelSlack) + origin;
    return static_cast<int>(std::clamp(pixel, from - 1.0f, static_cast<float>(to)));
  }

  float origin_x_, origin_y_, mean_x_, mean_y_;
  float reach_;
  float fall_x_, fall_y_;      // what is left of `reach_` at an offset along one axis, for the chord along the other
  float slope_x_, slope_y_;    // the chords' middles lie at dx = slope_x dy and dy = slope_y dx
  float inverse_x_, inverse_y_;
  float dy_of_right_, dx_of_bottom_;  // where the ellipse's extreme points lie
};

}  // namespace hgs
