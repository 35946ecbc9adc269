// From splats in space to ellipses on the screen, kLanes splats at a time (docs/numerics.md, "Projection").
#pragma once

#include "screen.hpp"
#include "wide.hpp"

namespace hgs {

// The camera and the range to which the Jacobian's direction is clamped.
struct CameraModel {
  hgs_camera exact;
  float R[9], fx, fy;
  double u_min, u_max, v_min, v_max;
  bool antialiased;
  double magnification[4];

  explicit CameraModel(const hgs_view &view)
      : exact(view.camera),
        fx(static_cast<float>(exact.fx)),
        fy(static_cast<float>(exact.fy)),
        antialiased(view.antialiased != 0) {
    for (int i = 0; i < 9; ++i) R[i] = static_cast<float>(exact.rotation[i]);
    for (int i = 0; i < 4; ++i) magnification[i] = view.magnification[i];
    const double margin_x = kFrustumMargin * 0.5 * exact.width / exact.fx;
    const double margin_y = kFrustumMargin * 0.5 * exact.height / exact.fy;
    u_min = -exact.cx / exact.fx - margin_x;
    u_max = (exact.width - exact.cx) / exact.fx + margin_x;
    v_min = -exact.cy / exact.fy - margin_y;
    v_max = (exact.height - exact.cy) / exact.fy + margin_y;
  }
};

// Splats at one moment.
struct Shape {
  Wide mean[3], quat[4];
  Vec log_scale[3], rgb[3];
};

struct ShapeGradient {
  Vec mean[3], log_scale[3], quat[4];
};

// dL / d of what compositing reads.
struct ScreenGradient {
  Vec mean_x, mean_y;  // pixels
  // Twice the gradient of the covariance in the coordinates of Round, where it is the identity.
  Vec round_tt, round_te, round_ee;
  Vec log_opacity, depth;
};

// A projected splat and the intermediate values that its derivative needs.
//
// With e_j the screen projection of the splat's unit axis j and s_j its scale, the screen covariance is
// C = sum_j s_j^2 e_j e_j^T + low_pass I. It is never inverted by the textbook formula, which cancels for long thin
// splats: its determinant and the products C^-1 e_j are expanded in the cross products e_i x e_j instead.
struct Projection {
  Vec variance[3];                 // s_j^2
  Vec unit_quat[4], inverse_norm;  // the norm's inverse is 0 for the quaternions that count as the identity
  Vec z, inverse_z, u, v, u_clamped, v_clamped;
  Wide exact_z, exact_u_clamped, exact_v_clamped;
  Vec axes[9];         // camera rotation x splat rotation: columns are the splat's unit axes in the camera
  Vec e_x[3], e_y[3];  // Jacobian x axes
  Vec cross[3];        // e_1 x e_2, e_2 x e_0, e_0 x e_1
  Vec low_pass;        // pixels^2, at least kLowPass
  Vec area;            // determinant of C without the low-pass filter
  Vec cov_xx, cov_xy, cov_yy;
  Vec conic_xx, conic_xy, conic_yy, conic_determinant;
  Mask usable;  // quaternions
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
  Vec q[4];
  for (int i = 0; i < 4; ++i) q[i] = narrow(shape.quat[i]);
  const Vec norm2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  const Mask usable = p.usable = greater_equal(norm2, broadcast(1e-24f));
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
  p.exact_z = z;
  p.exact_u_clamped = clamp(u, camera.u_min, camera.u_max);
  p.exact_v_clamped = clamp(v, camera.v_min, camera.v_max);
  p.u_clamped = narrow(p.exact_u_clamped);
  p.v_clamped = narrow(p.exact_v_clamped);

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
  // In two steps: the first changes no bit of what is not magnified.
  const double *const larger = camera.magnification;
  const Vec times = max(narrow(larger[0] * u + larger[1] * v + larger[3] * inverse_z + broadcast_wide(larger[2])), Vec{});
  const Vec wider = max(kLowPass * (times * times) - kLowPass, Vec{});
  const Vec wide_area = area + wider * (xx + yy) + wider * wider, wide_xx = xx + wider, wide_yy = yy + wider;
  p.low_pass = kLowPass + wider;
  p.cov_xx = wide_xx + kLowPass;
  p.cov_xy = xy;
  p.cov_yy = wide_yy + kLowPass;
  p.conic_determinant = 1.0f / (wide_area + kLowPass * (wide_xx + wide_yy) + kLowPass * kLowPass);
  p.conic_xx = p.cov_yy * p.conic_determinant;
  p.conic_xy = -p.cov_xy * p.conic_determinant;
  p.conic_yy = p.cov_xx * p.conic_determinant;
  return p;
}

// What antialiasing multiplies the squared opacity by: the share of its peak that the low-pass filter leaves a splat.
inline Vec compensation2(const Projection &p) { return p.area * p.conic_determinant; }

// -C_xy / C_yy: t is a multiple of dx + slope dy. In double precision, because a needle is thousands of pixels long; only
// the scales, which hardly matter to it, are taken in float32. Lengths count in units of z and quaternions keep theirs:
// the factor of z^2 |q|^4 cancels.
inline Wide exact_slope(const CameraModel &camera, const Shape &shape, const Projection &p) {
  const Wide known = widen(keep(p.usable, broadcast(1.0f)));  // 1, or 0 for what counts as the identity
  const Wide w = known * shape.quat[0] + (broadcast_wide(1.0) - known);
  const Wide x = known * shape.quat[1], y = known * shape.quat[2], z = known * shape.quat[3];
  const Wide ww = w * w, xx = x * x, yy = y * y, zz = z * z;
  const Wide xy = x * y, xz = x * z, yz = y * z, wx = w * x, wy = w * y, wz = w * z;
  const Wide Q[9] = {ww + xx - yy - zz, 2.0 * (xy - wz),   2.0 * (xz + wy),  //
                     2.0 * (xy + wz),   ww - xx + yy - zz, 2.0 * (yz - wx),  //
                     2.0 * (xz - wy),   2.0 * (yz + wx),   ww - xx - yy + zz};
  const hgs_camera &c = camera.exact;
  Wide across[3], down[3];  // rows of Jacobian x camera rotation
  for (int i = 0; i < 3; ++i) {
    across[i] = broadcast_wide(c.fx * c.rotation[i]) - (c.fx * c.rotation[6 + i]) * p.exact_u_clamped;
    down[i] = broadcast_wide(c.fy * c.rotation[3 + i]) - (c.fy * c.rotation[6 + i]) * p.exact_v_clamped;
  }
  const Wide length = p.exact_z * (ww + xx + yy + zz);
  Wide cov_xy = broadcast_wide(0.0), cov_yy = widen(p.low_pass) * (length * length);
  for (int j = 0; j < 3; ++j) {
    const Wide e_x = across[0] * Q[j] + across[1] * Q[3 + j] + across[2] * Q[6 + j];
    const Wide e_y = down[0] * Q[j] + down[1] * Q[3 + j] + down[2] * Q[6 + j];
    const Wide scaled = widen(p.variance[j]) * e_y;
    cov_xy = cov_xy + scaled * e_x;
    cov_yy = cov_yy + scaled * e_y;
  }
  return broadcast_wide(0.0) - cov_xy / cov_yy;
}

// U with U^T U = C^-1: it takes offsets on the screen, in pixels, to coordinates (t, e) in which the ellipse is a circle.
//     U = [t_by_x, t_by_y; 0, e_by_y]
// and (e_t, e_e) is what it makes of the projections e_j of the splat's unit axes. |s_j U e_j| is at most 1.
struct Round {
  Vec t_by_x, t_by_y, e_by_y;
  Vec e_t[3], e_e[3];

  explicit Round(const Projection &p) {
    e_by_y = 1.0f / sqrt(p.cov_yy);
    t_by_x = sqrt(p.conic_xx);
    t_by_y = p.conic_xy / t_by_x;
    const Vec scale = sqrt(p.conic_determinant) * e_by_y;
    for (int j = 0; j < 3; ++j) {
      const int k = (j + 1) % 3, l = (j + 2) % 3;
      const Vec with_k = p.variance[k] * p.cross[l], with_l = p.variance[l] * p.cross[k];
      e_t[j] = scale * (p.low_pass * p.e_x[j] + with_k * p.e_y[k] - with_l * p.e_y[l]);
      e_e[j] = e_by_y * p.e_y[j];
    }
  }
};

inline ShapeGradient project_backward(const CameraModel &camera, const Projection &p, const Round &round,
                                      const ScreenGradient &g) {
  ShapeGradient out;

  // v_j = 2 (dL / dC in round coordinates) U e_j.
  Vec v_t[3], v_e[3];
  for (int j = 0; j < 3; ++j) {
    v_t[j] = g.round_tt * round.e_t[j] + g.round_te * round.e_e[j];
    v_e[j] = g.round_te * round.e_t[j] + g.round_ee * round.e_e[j];
  }

  // With antialiasing, ln opacity has the term ln(det C0 / det C) / 2, C0 being C without the filter. Its gradient by C is
  // H = (C0^-1 - C^-1) / 2 = c adj C0 - low_pass / (2 det C) I with c > 0. With adj C0 expanded in the cross products,
  // a_j = H e_j, straight_j = e_j H e_j and across_j = e_k H e_l lose no digits to long thin splats.
  Vec a_x[3] = {}, a_y[3] = {}, straight[3] = {}, across[3] = {};
  if (camera.antialiased) {
    const Mask free = greater(compensation2(p), broadcast(kCompensationMin2));
    const Vec weight = keep(free, 0.5f * g.log_opacity);
    const Vec filtered = p.low_pass * (p.cov_xx + p.cov_yy - p.low_pass);  // det C - det C0
    const Vec share = weight * filtered * p.conic_determinant * keep(free, 1.0f / p.area);
    const Vec low = weight * p.low_pass * p.conic_determinant;
    for (int j = 0; j < 3; ++j) {
      const int k = (j + 1) % 3, l = (j + 2) % 3;
      const Vec with_k = p.variance[k] * p.cross[l], with_l = p.variance[l] * p.cross[k];
      a_x[j] = share * (with_k * p.e_y[k] - with_l * p.e_y[l]) - low * p.e_x[j];
      a_y[j] = share * (with_l * p.e_x[l] - with_k * p.e_x[k]) - low * p.e_y[j];
      straight[j] = share * (with_k * p.cross[l] + with_l * p.cross[k]) - low * (p.e_x[j] * p.e_x[j] + p.e_y[j] * p.e_y[j]);
      across[j] = -share * p.variance[j] * p.cross[k] * p.cross[l] - low * (p.e_x[k] * p.e_x[l] + p.e_y[k] * p.e_y[l]);
    }
  }

  // Scales: dC = 2 s_j^2 e_j e_j^T d ln s_j gives dL / d ln s_j = s_j^2 (U e_j) . v_j. Rotation: a turn by t about axis j of
  // the splat mixes the other two axes, so dL / dt = (s_k^2 - s_l^2) (U e_k) . v_l, and dq = q (0, t) / 2.
  Vec turn[3];
  for (int j = 0; j < 3; ++j) {
    const int k = (j + 1) % 3, l = (j + 2) % 3;
    out.log_scale[j] = p.variance[j] * (2.0f * straight[j] + round.e_t[j] * v_t[j] + round.e_e[j] * v_e[j]);
    turn[j] = (p.variance[k] - p.variance[l]) * (2.0f * across[j] + round.e_t[k] * v_t[l] + round.e_e[k] * v_e[l]);
  }
  const Vec *q = p.unit_quat, twice = 2.0f * p.inverse_norm;
  out.quat[0] = -twice * (q[1] * turn[0] + q[2] * turn[1] + q[3] * turn[2]);
  out.quat[1] = twice * (q[0] * turn[0] + q[2] * turn[2] - q[3] * turn[1]);
  out.quat[2] = twice * (q[0] * turn[1] + q[3] * turn[0] - q[1] * turn[2]);
  out.quat[3] = twice * (q[0] * turn[2] + q[1] * turn[1] - q[2] * turn[0]);

  // The Jacobian's entries by u and v, [jx, 0, -jx u; 0, jy, -jy v]: sums over the axes of s_j^2 U^T v_j times the axis.
  const Vec jx = camera.fx * p.inverse_z, jy = camera.fy * p.inverse_z;
  Vec d_jxz{}, d_jyz{};
  for (int j = 0; j < 3; ++j) {
    d_jxz += p.variance[j] * (2.0f * a_x[j] + round.t_by_x * v_t[j]) * p.axes[6 + j];
    d_jyz += p.variance[j] * (2.0f * a_y[j] + round.t_by_y * v_t[j] + round.e_by_y * v_e[j]) * p.axes[6 + j];
  }

  // Mean: through the direction (u, v), which the clamp cuts off from the Jacobian, and through 1 / z, by which the whole
  // Jacobian is multiplied as by a factor common to all scales.
  const auto within = [](Vec x, double low, double high) {
    return both(greater_equal(x, broadcast(static_cast<float>(low))), greater_equal(broadcast(static_cast<float>(high)), x));
  };
  const Mask u_free = within(p.u, camera.u_min, camera.u_max), v_free = within(p.v, camera.v_min, camera.v_max);
  const Vec d_ln_scales = out.log_scale[0] + out.log_scale[1] + out.log_scale[2];
  const Vec d_u = camera.fx * g.mean_x - keep(u_free, jx * d_jxz);
  const Vec d_v = camera.fy * g.mean_y - keep(v_free, jy * d_jyz);
  const Vec d_x = d_u * p.inverse_z, d_y = d_v * p.inverse_z;
  const Vec d_z = g.depth - p.inverse_z * (d_u * p.u + d_v * p.v + d_ln_scales);
  const float *R = camera.R;
  for (int i = 0; i < 3; ++i) out.mean[i] = R[i] * d_x + R[3 + i] * d_y + R[6 + i] * d_z;
  return out;
}

}  // namespace hgs
