// From splats in space to ellipses on the screen, kLanes splats at a time (docs/numerics.md, "Projection").
#pragma once

#include "screen.hpp"
#include "wide.hpp"

namespace hgs {

// The camera and the range to which the Jacobian's direction is clamped.
struct CameraModel {
  hgs_camera exact;
  float R[9], fx, fy;
  float u_min, u_max, v_min, v_max;
  bool antialiased;

  explicit CameraModel(const hgs_view &view)
      : exact(view.camera),
        fx(static_cast<float>(exact.fx)),
        fy(static_cast<float>(exact.fy)),
        antialiased(view.antialiased != 0) {
    for (int i = 0; i < 9; ++i) R[i] = static_cast<float>(exact.rotation[i]);
    const double margin_x = kFrustumMargin * 0.5 * exact.width / exact.fx;
    const double margin_y = kFrustumMargin * 0.5 * exact.height / exact.fy;
    u_min = static_cast<float>(-exact.cx / exact.fx - margin_x);
    u_max = static_cast<float>((exact.width - exact.cx) / exact.fx + margin_x);
    v_min = static_cast<float>(-exact.cy / exact.fy - margin_y);
    v_max = static_cast<float>((exact.height - exact.cy) / exact.fy + margin_y);
  }
};

// Splats at one moment.
struct Shape {
  Wide mean[3];
  Vec log_scale[3], quat[4], rgb[3];
};

struct ShapeGradient {
  Vec mean[3], log_scale[3], quat[4];
};

// dL / d of what compositing reads.
struct ScreenGradient {
  Vec mean_x, mean_y;                // pixels
  Vec conic_xx, conic_xy, conic_yy;  // conic_xy counts both off-diagonal elements
  Vec log_opacity, depth;
};

// A projected splat and the intermediate values that its derivative needs.
//
// With e_j the screen projection of the splat's unit axis j and s_j its scale, the screen covariance is
// C = sum_j s_j^2 e_j e_j^T + kLowPass I. It is never inverted by the textbook formula, which cancels for long thin
// splats: its determinant and the products C^-1 e_j are expanded in the cross products e_i x e_j instead.
struct Projection {
  Vec variance[3];                 // s_j^2
  Vec unit_quat[4], inverse_norm;  // the norm's inverse is 0 for the quaternions that count as the identity
  Vec z, inverse_z, u, v, u_clamped, v_clamped;
  Vec axes[9];         // camera rotation x splat rotation: columns are the splat's unit axes in the camera
  Vec e_x[3], e_y[3];  // Jacobian x axes
  Vec cross[3];        // e_1 x e_2, e_2 x e_0, e_0 x e_1
  Vec area;            // determinant of C without the low-pass filter
  Vec cov_xx, cov_xy, cov_yy;
  Vec conic_xx, conic_xy, conic_yy, conic_determinant;
  Wide mean_x, mean_y;        // pixels
  Vec distance_to_near_plane;  // z minus the near plane
};

inline void rotation_matrix(const Vec *q, Vec *R) {
  const Vec w = q[0], x = q[1], y = q[2], z = q[3];
  R[0] = 1.0f - 2.0f * (y * y + z * z);
  R[1] = 2.0f * (x * y - w * z);
  R[2] = 2.0f * (x * z + w * y);
  R[3] = 2.0f * (x * y + w * z);
  R[4] = 1.0f - 2.0f * (x * x + z * z);
  R[5] = 2.0f * (y * z - w * x);
  R[6] = 2.0f * (x * z - w * y);
  R[7] = 2.0f * (y * z + w * x);
  R[8] = 1.0f - 2.0f * (x * x + y * y);
}

inline Projection project(const CameraModel &camera, const Shape &shape) {
  Projection p;
  const float *const R = camera.R;

  for (int j = 0; j < 3; ++j) p.variance[j] = exp(2.0f * shape.log_scale[j]);
  const Vec *q = shape.quat;
  const Vec norm2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  const Mask usable = greater_equal(norm2, broadcast(1e-24f));
  // By way of the largest component, and smaller by 2^40 throughout: squares and reciprocals of long ones leave float32.
  constexpr float kSmaller = 0x1p-40f;
  const Vec largest = max(max(abs(q[0]), abs(q[1])), max(abs(q[2]), abs(q[3])));
  const Vec unit = 1.0f / (largest * kSmaller);
  Vec scaled[4], scaled_norm2{};
  for (int i = 0; i < 4; ++i) {
    scaled[i] = q[i] * kSmaller * unit;
    scaled_norm2 += scaled[i] * scaled[i];
  }
  const Vec inverse_scaled_norm = 1.0f / sqrt(scaled_norm2);
  p.inverse_norm = keep(usable, kSmaller * unit * inverse_scaled_norm);
  for (int i = 0; i < 4; ++i) p.unit_quat[i] = keep(usable, scaled[i] * inverse_scaled_norm);
  p.unit_quat[0] = select(usable, p.unit_quat[0], broadcast(1.0f));

  // In double precision: on the screen, float32 would leave errors of 1e-5 pixels, and 1e6 units from the origin, any.
  const hgs_camera &c = camera.exact;
  const Wide *m = shape.mean;
  const auto in_camera = [&](int i) {
    return c.rotation[3 * i] * m[0] + c.rotation[3 * i + 1] * m[1] + c.rotation[3 * i + 2] * m[2] +
           broadcast_wide(c.translation[i]);
  };
  const Wide z = in_camera(2), inverse_z = broadcast_wide(1.0) / z;
  const Wide u = in_camera(0) * inverse_z, v = in_camera(1) * inverse_z;
  p.mean_x = c.fx * u + broadcast_wide(c.cx);
  p.mean_y = c.fy * v + broadcast_wide(c.cy);
  p.distance_to_near_plane = narrow(z - broadcast_wide(c.near_plane));
  p.z = narrow(z);
  p.inverse_z = narrow(inverse_z);
  p.u = narrow(u);
  p.v = narrow(v);
  p.u_clamped = clamp(p.u, camera.u_min, camera.u_max);
  p.v_clamped = clamp(p.v, camera.v_min, camera.v_max);

  Vec Q[9];
  rotation_matrix(p.unit_quat, Q);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) p.axes[3 * i + j] = R[3 * i] * Q[j] + R[3 * i + 1] * Q[3 + j] + R[3 * i + 2] * Q[6 + j];
  }
  const Vec jx = camera.fx * p.inverse_z, jy = camera.fy * p.inverse_z;
  for (int j = 0; j < 3; ++j) {
    p.e_x[j] = jx * (p.axes[j] - p.u_clamped * p.axes[6 + j]);
    p.e_y[j] = jy * (p.axes[3 + j] - p.v_clamped * p.axes[6 + j]);
  }

  Vec xx{}, xy{}, yy{}, area{};
  for (int j = 0; j < 3; ++j) {
    const int k = (j + 1) % 3, l = (j + 2) % 3;
    p.cross[j] = p.e_x[k] * p.e_y[l] - p.e_y[k] * p.e_x[l];
    xx += p.variance[j] * p.e_x[j] * p.e_x[j];
    xy += p.variance[j] * p.e_x[j] * p.e_y[j];
    yy += p.variance[j] * p.e_y[j] * p.e_y[j];
    area += p.variance[k] * p.variance[l] * p.cross[j] * p.cross[j];
  }
  p.area = area;
  p.cov_xx = xx + kLowPass;
  p.cov_xy = xy;
  p.cov_yy = yy + kLowPass;
  p.conic_determinant = 1.0f / (area + kLowPass * (xx + yy) + kLowPass * kLowPass);
  p.conic_xx = p.cov_yy * p.conic_determinant;
  p.conic_xy = -p.cov_xy * p.conic_determinant;
  p.conic_yy = p.cov_xx * p.conic_determinant;
  return p;
}

// What antialiasing multiplies the squared opacity by: the share of its peak that the low-pass filter leaves a splat.
inline Vec compensation2(const Projection &p) { return p.area * p.conic_determinant; }

inline ShapeGradient project_backward(const CameraModel &camera, const Projection &p, const ScreenGradient &g) {
  ShapeGradient out;

  // y_j = C^-1 e_j, and f_j = G y_j with G the symmetric gradient of the conic.
  Vec y_x[3], y_y[3], f_x[3], f_y[3];
  const Vec g_xy = 0.5f * g.conic_xy;
  for (int j = 0; j < 3; ++j) {
    const int k = (j + 1) % 3, l = (j + 2) % 3;
    const Vec with_k = p.variance[k] * p.cross[l], with_l = p.variance[l] * p.cross[k];
    y_x[j] = p.conic_determinant * (kLowPass * p.e_x[j] + with_k * p.e_y[k] - with_l * p.e_y[l]);
    y_y[j] = p.conic_determinant * (kLowPass * p.e_y[j] - with_k * p.e_x[k] + with_l * p.e_x[l]);
    f_x[j] = g.conic_xx * y_x[j] + g_xy * y_y[j];
    f_y[j] = g_xy * y_x[j] + g.conic_yy * y_y[j];
  }

  // With antialiasing, ln opacity has the term ln(det C0 / det C) / 2, C0 being C without the filter. Its gradient by C is
  // H = (C0^-1 - C^-1) / 2 = c adj C0 - kLowPass / (2 det C) I with c > 0. With adj C0 expanded in the cross products,
  // a_j = H e_j, straight_j = e_j H e_j and across_j = e_k H e_l lose no digits to long thin splats.
  Vec a_x[3] = {}, a_y[3] = {}, straight[3] = {}, across[3] = {};
  if (camera.antialiased) {
    const Mask free = greater(compensation2(p), broadcast(kCompensationMin2));
    const Vec weight = keep(free, 0.5f * g.log_opacity);
    const Vec filtered = kLowPass * (p.cov_xx + p.cov_yy - kLowPass);  // det C - det C0
    const Vec share = weight * filtered * p.conic_determinant * keep(free, 1.0f / p.area);
    const Vec low = weight * kLowPass * p.conic_determinant;
    for (int j = 0; j < 3; ++j) {
      const int k = (j + 1) % 3, l = (j + 2) % 3;
      const Vec with_k = p.variance[k] * p.cross[l], with_l = p.variance[l] * p.cross[k];
      a_x[j] = share * (with_k * p.e_y[k] - with_l * p.e_y[l]) - low * p.e_x[j];
      a_y[j] = share * (with_l * p.e_x[l] - with_k * p.e_x[k]) - low * p.e_y[j];
      straight[j] = share * (with_k * p.cross[l] + with_l * p.cross[k]) - low * (p.e_x[j] * p.e_x[j] + p.e_y[j] * p.e_y[j]);
      across[j] = -share * p.variance[j] * p.cross[k] * p.cross[l] - low * (p.e_x[k] * p.e_x[l] + p.e_y[k] * p.e_y[l]);
    }
  }

  // Scales: d(C^-1) = -C^-1 dC C^-1 gives dL / d ln s_j = -2 s_j^2 y_j^T G y_j. Rotation: a turn by t about axis j of the
  // splat mixes the other two axes, so dL / dt = 2 (s_l^2 - s_k^2) y_k^T G y_l, and dq = q (0, t) / 2.
  Vec turn[3];
  for (int j = 0; j < 3; ++j) {
    const int k = (j + 1) % 3, l = (j + 2) % 3;
    out.log_scale[j] = 2.0f * p.variance[j] * (straight[j] - y_x[j] * f_x[j] - y_y[j] * f_y[j]);
    turn[j] = 2.0f * (p.variance[l] - p.variance[k]) * (y_x[k] * f_x[l] + y_y[k] * f_y[l] - across[j]);
  }
  const Vec *q = p.unit_quat, twice = 2.0f * p.inverse_norm;
  out.quat[0] = -twice * (q[1] * turn[0] + q[2] * turn[1] + q[3] * turn[2]);
  out.quat[1] = twice * (q[0] * turn[0] + q[2] * turn[2] - q[3] * turn[1]);
  out.quat[2] = twice * (q[0] * turn[1] + q[3] * turn[0] - q[1] * turn[2]);
  out.quat[3] = twice * (q[0] * turn[2] + q[1] * turn[1] - q[2] * turn[0]);

  // Jacobian [jx, 0, jxz; 0, jy, jyz]: its gradient is the sum over the axes of -2 s_j^2 C^-1 f_j times the axis.
  const Vec jx = camera.fx * p.inverse_z, jy = camera.fy * p.inverse_z;
  const Vec jxz = -jx * p.u_clamped, jyz = -jy * p.v_clamped;
  Vec d_jx{}, d_jxz{}, d_jy{}, d_jyz{};
  for (int j = 0; j < 3; ++j) {
    const Vec d_x = 2.0f * p.variance[j] * (a_x[j] - p.conic_xx * f_x[j] - p.conic_xy * f_y[j]);
    const Vec d_y = 2.0f * p.variance[j] * (a_y[j] - p.conic_xy * f_x[j] - p.conic_yy * f_y[j]);
    d_jx += d_x * p.axes[j];
    d_jxz += d_x * p.axes[6 + j];
    d_jy += d_y * p.axes[3 + j];
    d_jyz += d_y * p.axes[6 + j];
  }

  // Mean: through the direction (u, v), which the clamp cuts off from the Jacobian, and through 1 / z.
  const Mask u_free = both(greater_equal(p.u, broadcast(camera.u_min)), greater_equal(broadcast(camera.u_max), p.u));
  const Mask v_free = both(greater_equal(p.v, broadcast(camera.v_min)), greater_equal(broadcast(camera.v_max), p.v));
  const Vec d_u = camera.fx * g.mean_x - keep(u_free, jx * d_jxz);
  const Vec d_v = camera.fy * g.mean_y - keep(v_free, jy * d_jyz);
  const Vec d_x = d_u * p.inverse_z, d_y = d_v * p.inverse_z;
  const Vec d_z = g.depth - p.inverse_z * (d_u * p.u + d_v * p.v + d_jx * jx + d_jxz * jxz + d_jy * jy + d_jyz * jyz);
  const float *R = camera.R;
  for (int i = 0; i < 3; ++i) out.mean[i] = R[i] * d_x + R[3 + i] * d_y + R[6 + i] * d_z;
  return out;
}

}  // namespace hgs
