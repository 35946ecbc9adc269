"""From the sums over a splat's pixels to the gradients of its parameters: one lane per splat, in float64."""

import triton
import triton.language as tl

from hgs_core.render.triton.kernels.constants import (
    COMPENSATION_MIN_2,
    EXPONENT_ROOT,
    EXPONENT_SCALE,
    TERMS,
    TIME_LOG_PRECISION_MAX,
)
from hgs_core.render.triton.kernels.projection import (
    camera_space,
    clamped_direction,
    covariance,
    fade,
    load3,
    load4,
    low_pass_at,
    moved,
    screen_axes,
    sigmoid,
    unit_quaternion,
    velocity,
)

__all__ = ["differentiate_dynamics", "differentiate_statics"]


@triton.jit
def store3(array, at, x, y, z, mask):
    """Three consecutive values, as float32; nothing if nobody wants the array."""
    if array is not None:
        tl.store(array + at, x.to(tl.float32), mask=mask)
        tl.store(array + at + 1, y.to(tl.float32), mask=mask)
        tl.store(array + at + 2, z.to(tl.float32), mask=mask)


@triton.jit
def store4(array, at, w, x, y, z, mask):
    """Four consecutive values, as float32; nothing if nobody wants the array."""
    if array is not None:
        tl.store(array + at, w.to(tl.float32), mask=mask)
        store3(array, at + 1, x, y, z, mask)


@triton.jit
def store1(array, at, x, mask):
    """One value, as float32; nothing if nobody wants the array."""
    if array is not None:
        tl.store(array + at, x.to(tl.float32), mask=mask)


@triton.jit
def by_axis(with_k, with_l, xk, xl, yk, yl, share, low, xj, yj, ck, cl, vj):
    """Antialiasing's part for axis j; k and l are the axes after it. See `shape_gradient`."""
    a_x = share * (with_k * yk - with_l * yl) - low * xj
    a_y = share * (with_l * xl - with_k * xk) - low * yj
    straight = share * (with_k * cl + with_l * ck) - low * (xj * xj + yj * yj)
    mixed = -share * vj * ck * cl - low * (xk * xl + yk * yl)
    return a_x, a_y, straight, mixed


@triton.jit
def shape_gradient(
    camera, sums, pulls, row, mask, drawn, X, Y, Z, s0, s1, s2, qw, qx, qy, qz, ANTIALIASED: tl.constexpr
):
    """Gradients of mean, log-scales and quaternion of splats at (X, Y, Z) in the camera; 0 where not drawn.

    With e_j the screen projection of axis j, s_j its scale, U e_j = (t_j, e_j) and G the gradient by C in round
    coordinates: dL / d ln s_j = s_j^2 (U e_j) . v_j with v_j = 2 G U e_j; a turn about axis j mixes the other two axes,
    so dL / d turn = (s_k^2 - s_l^2) (U e_k) . v_l, and dq = q (0, turn) / 2.
    """
    at = sums + row * TERMS
    sum_t = tl.load(at, mask=drawn, other=0.0).to(tl.float64)
    sum_e = tl.load(at + 1, mask=drawn, other=0.0).to(tl.float64)
    g_tt = tl.load(at + 2, mask=drawn, other=0.0).to(tl.float64) / EXPONENT_SCALE
    g_te = tl.load(at + 3, mask=drawn, other=0.0).to(tl.float64) / EXPONENT_SCALE
    g_ee = tl.load(at + 4, mask=drawn, other=0.0).to(tl.float64) / EXPONENT_SCALE
    g_log_opacity = tl.load(at + 8, mask=drawn, other=0.0).to(tl.float64)
    g_depth = tl.load(at + 9, mask=drawn, other=0.0).to(tl.float64)

    z = tl.where(drawn, Z, 1.0)
    u, v = tl.where(drawn, X, 0.0) / z, tl.where(drawn, Y, 0.0) / z
    fx, fy = tl.load(camera + 12), tl.load(camera + 13)
    uc, vc = clamped_direction(camera, u, v)
    w, x, y, zq, inverse_norm = unit_quaternion(qw, qx, qy, qz)
    jx, jy = fx / z, fy / z
    x0, x1, x2, y0, y1, y2, z0, z1, z2 = screen_axes(camera, uc, vc, jx, jy, w, x, y, zq)
    v0, v1, v2 = tl.exp(2.0 * s0), tl.exp(2.0 * s1), tl.exp(2.0 * s2)
    low_pass = low_pass_at(camera, u, v, z)
    c0, c1, c2, area, cov_xx, cov_xy, cov_yy, det = covariance(v0, v1, v2, x0, x1, x2, y0, y1, y2, low_pass)

    # U = [t_by_x, t_by_y; 0, e_by_y], and U e_j expanded in the cross products.
    e_by_y = 1.0 / tl.sqrt(cov_yy)
    t_by_x = tl.sqrt(cov_yy / det)
    t_by_y = -cov_xy * e_by_y / tl.sqrt(det)
    scale = e_by_y / tl.sqrt(det)
    t0 = scale * (x0 * low_pass + v1 * c2 * y1 - v2 * c1 * y2)
    t1 = scale * (x1 * low_pass + v2 * c0 * y2 - v0 * c2 * y0)
    t2 = scale * (x2 * low_pass + v0 * c1 * y0 - v1 * c0 * y1)
    e0, e1, e2 = e_by_y * y0, e_by_y * y1, e_by_y * y2
    vt0, ve0 = g_tt * t0 + g_te * e0, g_te * t0 + g_ee * e0
    vt1, ve1 = g_tt * t1 + g_te * e1, g_te * t1 + g_ee * e1
    vt2, ve2 = g_tt * t2 + g_te * e2, g_te * t2 + g_ee * e2
    d0, d1, d2 = t0 * vt0 + e0 * ve0, t1 * vt1 + e1 * ve1, t2 * vt2 + e2 * ve2
    m0, m1, m2 = t1 * vt2 + e1 * ve2, t2 * vt0 + e2 * ve0, t0 * vt1 + e0 * ve1
    bx0, bx1, bx2 = t_by_x * vt0, t_by_x * vt1, t_by_x * vt2
    by0, by1, by2 = t_by_y * vt0 + e_by_y * ve0, t_by_y * vt1 + e_by_y * ve1, t_by_y * vt2 + e_by_y * ve2

    if ANTIALIASED:
        # ln opacity has the term ln(det C0 / det C) / 2; its gradient by C is c adj C0 - low_pass / (2 det C) I, c > 0.
        free = area > det * COMPENSATION_MIN_2
        weight = tl.where(free, 0.5 * g_log_opacity, 0.0)
        filtered = (cov_xx + cov_yy - low_pass) * low_pass  # det C - det C0
        share = weight * filtered / (det * tl.where(free, area, 1.0))
        low = weight * low_pass / det
        ax0, ay0, straight0, mixed0 = by_axis(v1 * c2, v2 * c1, x1, x2, y1, y2, share, low, x0, y0, c1, c2, v0)
        ax1, ay1, straight1, mixed1 = by_axis(v2 * c0, v0 * c2, x2, x0, y2, y0, share, low, x1, y1, c2, c0, v1)
        ax2, ay2, straight2, mixed2 = by_axis(v0 * c1, v1 * c0, x0, x1, y0, y1, share, low, x2, y2, c0, c1, v2)
        d0, d1, d2 = d0 + 2.0 * straight0, d1 + 2.0 * straight1, d2 + 2.0 * straight2
        m0, m1, m2 = m0 + 2.0 * mixed0, m1 + 2.0 * mixed1, m2 + 2.0 * mixed2
        bx0, bx1, bx2 = bx0 + 2.0 * ax0, bx1 + 2.0 * ax1, bx2 + 2.0 * ax2
        by0, by1, by2 = by0 + 2.0 * ay0, by1 + 2.0 * ay1, by2 + 2.0 * ay2

    d0, d1, d2 = v0 * d0, v1 * d1, v2 * d2
    m0, m1, m2 = (v1 - v2) * m0, (v2 - v0) * m1, (v0 - v1) * m2
    twice = 2.0 * inverse_norm
    dw = -twice * (x * m0 + y * m1 + zq * m2)
    dx = twice * (w * m0 + y * m2 - zq * m1)
    dy = twice * (w * m1 + zq * m0 - x * m2)
    dz = twice * (w * m2 + x * m1 - y * m0)

    # Mean: through the direction, which the clamp cuts off from the Jacobian, and through 1 / z, by which the whole
    # Jacobian is multiplied as by a factor common to all scales.
    g_mean_x = t_by_x * sum_t / EXPONENT_ROOT
    g_mean_y = (t_by_y * sum_t + e_by_y * sum_e) / EXPONENT_ROOT
    if pulls is not None:
        pull_x = t_by_x * tl.load(at + 10, mask=drawn, other=0.0) / EXPONENT_ROOT
        pull_y = tl.load(at + 11, mask=drawn, other=0.0) / EXPONENT_SCALE
        pull = tl.sqrt(pull_x * pull_x + pull_y * pull_y)
        tl.store(pulls + row, tl.where(drawn, pull, 0.0).to(tl.float32), mask=mask)
    d_u = fx * g_mean_x - tl.where(uc == u, jx * (v0 * bx0 * z0 + v1 * bx1 * z1 + v2 * bx2 * z2), 0.0)
    d_v = fy * g_mean_y - tl.where(vc == v, jy * (v0 * by0 * z0 + v1 * by1 * z1 + v2 * by2 * z2), 0.0)
    gx, gy = d_u / z, d_v / z
    gz = g_depth - (d_u * u + d_v * v + d0 + d1 + d2) / z
    gmx = tl.load(camera) * gx + tl.load(camera + 3) * gy + tl.load(camera + 6) * gz
    gmy = tl.load(camera + 1) * gx + tl.load(camera + 4) * gy + tl.load(camera + 7) * gz
    gmz = tl.load(camera + 2) * gx + tl.load(camera + 5) * gy + tl.load(camera + 8) * gz
    return gmx, gmy, gmz, d0, d1, d2, dw, dx, dy, dz, g_log_opacity


@triton.jit
def differentiate_statics(
    means,
    log_scales,
    quats,
    opacity_logits,
    count,
    camera,
    depths,
    sums,
    pulls,
    d_means,
    d_log_scales,
    d_quats,
    d_opacity_logits,
    d_rgb,
    ANTIALIASED: tl.constexpr,
    BLOCK: tl.constexpr,
):
    """Gradients of `count` static splats from the first row of `depths` and `sums`; None: not wanted."""
    row = tl.program_id(0) * BLOCK + tl.arange(0, BLOCK)
    mask = row < count
    drawn = mask & (tl.load(depths + row, mask=mask, other=float("inf")) < float("inf"))
    mx, my, mz = load3(means, row * 3, drawn)
    X, Y, Z = camera_space(camera, mx, my, mz)
    s0, s1, s2 = load3(log_scales, row * 3, drawn)
    qw, qx, qy, qz = load4(quats, row * 4, drawn)
    gmx, gmy, gmz, d0, d1, d2, dw, dx, dy, dz, g_log_opacity = shape_gradient(
        camera, sums, pulls, row, mask, drawn, X, Y, Z, s0, s1, s2, qw, qx, qy, qz, ANTIALIASED
    )
    sigma = sigmoid(tl.load(opacity_logits + row, mask=drawn, other=0.0).to(tl.float64))
    store3(d_means, row * 3, gmx, gmy, gmz, mask)
    store3(d_log_scales, row * 3, d0, d1, d2, mask)
    store4(d_quats, row * 4, dw, dx, dy, dz, mask)
    store1(d_opacity_logits, row, g_log_opacity * (1.0 - sigma), mask)
    red, green, blue = load3(sums, row * TERMS + 5, drawn)
    store3(d_rgb, row * 3, red, green, blue, mask)


@triton.jit
def differentiate_dynamics(
    motion,
    rotation,
    log_scales,
    opacity_logits,
    time_centers,
    time_log_precisions,
    count,
    camera,
    depths,
    sums,
    pulls,
    d_motion,
    d_rotation,
    d_log_scales,
    d_opacity_logits,
    d_time_centers,
    d_time_log_precisions,
    d_rgb,
    COEFFICIENTS: tl.constexpr,
    ANTIALIASED: tl.constexpr,
    BLOCK: tl.constexpr,
):
    """The same of dynamic splats: o = sigma exp(-s d^2), so d ln o / d d = -2 s d and d ln o / d ln s = -s d^2."""
    row = tl.program_id(0) * BLOCK + tl.arange(0, BLOCK)
    mask = row < count
    drawn = mask & (tl.load(depths + row, mask=mask, other=float("inf")) < float("inf"))
    center = tl.load(time_centers + row, mask=drawn, other=0.0).to(tl.float64)
    log_precision = tl.load(time_log_precisions + row, mask=drawn, other=0.0).to(tl.float64)
    d, precision, _ = fade(center, log_precision, tl.load(camera + 23))
    at = row * (3 * COEFFICIENTS)
    mx, my = moved(motion, at, d, drawn, COEFFICIENTS), moved(motion, at + 1, d, drawn, COEFFICIENTS)
    X, Y, Z = camera_space(camera, mx, my, moved(motion, at + 2, d, drawn, COEFFICIENTS))
    s0, s1, s2 = load3(log_scales, row * 3, drawn)
    qw, qx, qy, qz = load4(rotation, row * 8, drawn)
    rw, rx, ry, rz = load4(rotation, row * 8 + 4, drawn)
    gmx, gmy, gmz, d0, d1, d2, dw, dx, dy, dz, g_log_opacity = shape_gradient(
        camera,
        sums,
        pulls,
        row,
        mask,
        drawn,
        X,
        Y,
        Z,
        s0,
        s1,
        s2,
        qw + d * rw,
        qx + d * rx,
        qy + d * ry,
        qz + d * rz,
        ANTIALIASED,
    )
    d_offset = -2.0 * g_log_opacity * precision * d
    d_offset += gmx * velocity(motion, at, d, drawn, COEFFICIENTS)
    d_offset += gmy * velocity(motion, at + 1, d, drawn, COEFFICIENTS)
    d_offset += gmz * velocity(motion, at + 2, d, drawn, COEFFICIENTS)
    d_offset += dw * rw + dx * rx + dy * ry + dz * rz
    sigma = sigmoid(tl.load(opacity_logits + row, mask=drawn, other=0.0).to(tl.float64))
    by_precision = tl.where(log_precision <= TIME_LOG_PRECISION_MAX, -g_log_opacity * precision * d * d, 0.0)
    store3(d_motion, at, gmx, gmy, gmz, mask)
    for k in tl.static_range(1, COEFFICIENTS):
        gmx, gmy, gmz = d * gmx, d * gmy, d * gmz
        store3(d_motion, at + 3 * k, gmx, gmy, gmz, mask)
    store4(d_rotation, row * 8, dw, dx, dy, dz, mask)
    store4(d_rotation, row * 8 + 4, d * dw, d * dx, d * dy, d * dz, mask)
    store3(d_log_scales, row * 3, d0, d1, d2, mask)
    store1(d_opacity_logits, row, g_log_opacity * (1.0 - sigma), mask)
    store1(d_time_centers, row, -d_offset, mask)
    store1(d_time_log_precisions, row, by_precision, mask)
    red, green, blue = load3(sums, row * TERMS + 5, drawn)
    store3(d_rgb, row * 3, red, green, blue, mask)
