// From splats in space to ellipses on the screen, kLanes splats at a time (docs/numerics.md, "Projection").
#pragma once

#include "simd.hpp"
#include "workspace.hpp"

namespace hgs {

// The camera and the range to which the Jacobian's direction is clamped.
struct CameraModel {
  float R[9], t[3];
  float fx, fy, cx, cy;
  float u_min, u_max, v_min, v_max;

  explicit CameraModel(const hgs_camera &c) : fx(c.fx), fy(c.fy), cx(c.cx), cy(c.cy) {
    for (int i = 0; i < 9; ++i) R[i] = c.rotation[i];
    for (int i = 0; i < 3; ++i) t[i] = c.translation[i];
    const float width = static_cast<float>(c.width), height = static_cast<float>(c.height);
    const float margin_x = kFrustumMargin * 0.5f * width / fx, margin_y = kFrustumMargin * 0.5f * height / fy;
    u_min = -cx / fx - margin_x;
    u_max = (width - cx) / fx + margin_x;
    v_min = -cy / fy - margin_y;
    v_max = (height - cy) / fy + margin_y;
  }
};

// Splats at one moment.
struct Shape {
  Vec mean[3], log_scale[3], quat[4];
};

struct ShapeGradient {
  Vec mean[3], log_scale[3], quat[4];
};

// dL / d of what compositing reads.
struct ScreenGradient {
  Vec mean_x, mean_y;                       // pixels
  Vec conic_xx, conic_xy, conic_yy;         // conic_xy counts both off-diagonal elements
};

// A projected splat and the intermediate values that its derivative needs.
struct Projection {
  Vec scale[3];
  Vec unit_quat[4], inverse_norm;  // the norm's inverse is 0 for the quaternions that count as the identity
  Vec rotation[9];
  Vec z, inverse_z, u, v, u_clamped, v_clamped;
  Vec axes[9];            // camera rotation x splat rotation x scales: columns are the splat's axes in the camera
  Vec row_x[3], row_y[3];  // Jacobian x axes: the screen covariance is their Gram matrix plus the low-pass
  Vec cov_xx, cov_xy, cov_yy;
  Vec conic_xx, conic_xy, conic_yy, conic_determinant;
  Vec mean_x, mean_y;
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
  const float *R = camera.R;

  for (int i = 0; i < 3; ++i) p.scale[i] = exp(shape.log_scale[i]);
  const Vec *q = shape.quat;
  const Vec norm2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  const Mask usable = greater_equal(norm2, broadcast(1e-24f));
  p.inverse_norm = keep(usable, 1.0f / sqrt(norm2));
  for (int i = 0; i < 4; ++i) p.unit_quat[i] = keep(usable, q[i] * p.inverse_norm);
  p.unit_quat[0] = select(usable, p.unit_quat[0], broadcast(1.0f));
  rotation_matrix(p.unit_quat, p.rotation);

  const Vec *m = shape.mean;
  const Vec x = R[0] * m[0] + R[1] * m[1] + R[2] * m[2] + camera.t[0];
  const Vec y = R[3] * m[0] + R[4] * m[1] + R[5] * m[2] + camera.t[1];
  p.z = R[6] * m[0] + R[7] * m[1] + R[8] * m[2] + camera.t[2];
  p.inverse_z = 1.0f / p.z;
  p.u = x * p.inverse_z;
  p.v = y * p.inverse_z;
  p.u_clamped = clamp(p.u, camera.u_min, camera.u_max);
  p.v_clamped = clamp(p.v, camera.v_min, camera.v_max);
  p.mean_x = camera.fx * p.u + camera.cx;
  p.mean_y = camera.fy * p.v + camera.cy;

  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Vec *Q = p.rotation;
      p.axes[3 * i + j] = (R[3 * i] * Q[j] + R[3 * i + 1] * Q[3 + j] + R[3 * i + 2] * Q[6 + j]) * p.scale[j];
    }
  }
  const Vec jx = camera.fx * p.inverse_z, jy = camera.fy * p.inverse_z;
  for (int j = 0; j < 3; ++j) {
    p.row_x[j] = jx * (p.axes[j] - p.u_clamped * p.axes[6 + j]);
    p.row_y[j] = jy * (p.axes[3 + j] - p.v_clamped * p.axes[6 + j]);
  }
  const Vec *a = p.row_x, *b = p.row_y;
  const Vec aa = a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
  const Vec bb = b[0] * b[0] + b[1] * b[1] + b[2] * b[2];
  p.cov_xx = aa + kLowPass;
  p.cov_xy = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  p.cov_yy = bb + kLowPass;
  // det(A A^T + s I) = |a x b|^2 + s tr(A A^T) + s^2: unlike xx yy - xy^2 it does not cancel for long thin splats.
  const Vec c0 = a[1] * b[2] - a[2] * b[1], c1 = a[2] * b[0] - a[0] * b[2], c2 = a[0] * b[1] - a[1] * b[0];
  p.conic_determinant = 1.0f / (c0 * c0 + c1 * c1 + c2 * c2 + kLowPass * (aa + bb) + kLowPass * kLowPass);
  p.conic_xx = p.cov_yy * p.conic_determinant;
  p.conic_xy = -p.cov_xy * p.conic_determinant;
  p.conic_yy = p.cov_xx * p.conic_determinant;
  return p;
}

inline ShapeGradient project_backward(const CameraModel &camera, const Projection &p, const ScreenGradient &g) {
  ShapeGradient out;
  const float *R = camera.R;

  // Covariance: d(C^-1) = -C^-1 dC C^-1.
  const Vec kxx = p.conic_xx, kxy = p.conic_xy, kyy = p.conic_yy, half_xy = 0.5f * g.conic_xy;
  const Vec t00 = kxx * g.conic_xx + kxy * half_xy, t01 = kxx * half_xy + kxy * g.conic_yy;
  const Vec t10 = kxy * g.conic_xx + kyy * half_xy, t11 = kxy * half_xy + kyy * g.conic_yy;
  const Vec d_xx = -(t00 * kxx + t01 * kxy), d_xy = -(t00 * kxy + t01 * kyy), d_yy = -(t10 * kxy + t11 * kyy);

  // Jacobian and axes; jxz = -jx u', jyz = -jy v'.
  const Vec jx = camera.fx * p.inverse_z, jy = camera.fy * p.inverse_z;
  const Vec jxz = -jx * p.u_clamped, jyz = -jy * p.v_clamped;
  Vec d_jx{}, d_jxz{}, d_jy{}, d_jyz{}, d_axes[9];
  for (int j = 0; j < 3; ++j) {
    const Vec d_row_x = 2.0f * (d_xx * p.row_x[j] + d_xy * p.row_y[j]);
    const Vec d_row_y = 2.0f * (d_xy * p.row_x[j] + d_yy * p.row_y[j]);
    d_jx += d_row_x * p.axes[j];
    d_jxz += d_row_x * p.axes[6 + j];
    d_jy += d_row_y * p.axes[3 + j];
    d_jyz += d_row_y * p.axes[6 + j];
    d_axes[j] = jx * d_row_x;
    d_axes[3 + j] = jy * d_row_y;
    d_axes[6 + j] = jxz * d_row_x + jyz * d_row_y;
  }

  // Mean: through the direction (u, v), which the clamp cuts off from the Jacobian, and through 1 / z.
  const Mask u_free = both(greater_equal(p.u, broadcast(camera.u_min)), greater_equal(broadcast(camera.u_max), p.u));
  const Mask v_free = both(greater_equal(p.v, broadcast(camera.v_min)), greater_equal(broadcast(camera.v_max), p.v));
  const Vec d_u = camera.fx * g.mean_x - keep(u_free, jx * d_jxz);
  const Vec d_v = camera.fy * g.mean_y - keep(v_free, jy * d_jyz);
  const Vec d_x = d_u * p.inverse_z, d_y = d_v * p.inverse_z;
  const Vec d_z = -p.inverse_z * (d_u * p.u + d_v * p.v + d_jx * jx + d_jxz * jxz + d_jy * jy + d_jyz * jyz);
  for (int i = 0; i < 3; ++i) out.mean[i] = R[i] * d_x + R[3 + i] * d_y + R[6 + i] * d_z;

  // Scales and rotation.
  Vec d_Q[9];
  for (int j = 0; j < 3; ++j) {
    Vec d_scale{};
    for (int i = 0; i < 3; ++i) {
      const Vec d = R[i] * d_axes[j] + R[3 + i] * d_axes[3 + j] + R[6 + i] * d_axes[6 + j];
      d_scale += d * p.rotation[3 * i + j];
      d_Q[3 * i + j] = d * p.scale[j];
    }
    out.log_scale[j] = d_scale * p.scale[j];
  }
  const Vec w = p.unit_quat[0], x = p.unit_quat[1], y = p.unit_quat[2], z = p.unit_quat[3];
  Vec d_q[4];
  d_q[0] = 2.0f * (x * (d_Q[7] - d_Q[5]) + y * (d_Q[2] - d_Q[6]) + z * (d_Q[3] - d_Q[1]));
  d_q[1] = 2.0f * (y * (d_Q[1] + d_Q[3]) + z * (d_Q[2] + d_Q[6]) - 2.0f * x * (d_Q[4] + d_Q[8]) + w * (d_Q[7] - d_Q[5]));
  d_q[2] = 2.0f * (x * (d_Q[1] + d_Q[3]) + z * (d_Q[5] + d_Q[7]) - 2.0f * y * (d_Q[0] + d_Q[8]) + w * (d_Q[2] - d_Q[6]));
  d_q[3] = 2.0f * (x * (d_Q[2] + d_Q[6]) + y * (d_Q[5] + d_Q[7]) - 2.0f * z * (d_Q[0] + d_Q[4]) + w * (d_Q[3] - d_Q[1]));
  const Vec along = w * d_q[0] + x * d_q[1] + y * d_q[2] + z * d_q[3];
  for (int i = 0; i < 4; ++i) out.quat[i] = (d_q[i] - p.unit_quat[i] * along) * p.inverse_norm;
  return out;
}

}  // namespace hgs
