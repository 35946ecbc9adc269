"""Culling and projection, the equations of time included: one lane per splat."""

import triton
import triton.language as tl

from hgs_core.render.triton.kernels.constants import (
    COLOUR_MAX,
    COMPENSATION_MIN_2,
    COVARIANCE_MAX,
    DEPTH_MAX,
    ELLIPSE,
    EXPONENT_SCALE,
    FLOAT_MAX,
    PLACE,
    SPLAT,
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
)

__all__ = ["project_dynamics", "project_statics"]


@triton.jit
def all_finite(array, rows, mask, WIDTH: tl.constexpr, WIDEST: tl.constexpr, LIMIT: tl.constexpr):
    """Whether all values of every row lie within the limit; a NaN does not. WIDEST: a power of two from WIDTH."""
    column = tl.arange(0, WIDEST)
    inside = mask[:, None] & (column < WIDTH)[None, :]
    values = tl.load(array + rows[:, None] * WIDTH + column[None, :], mask=inside, other=0.0)
    return tl.min((tl.abs(values) <= LIMIT).to(tl.int32), axis=1) > 0


@triton.jit
def project_and_store(
    row,
    wanted,
    X,
    Y,
    Z,
    log_scale_0,
    log_scale_1,
    log_scale_2,
    qw,
    qx,
    qy,
    qz,
    opacity,
    red,
    green,
    blue,
    camera,
    splats,
    places,
    ellipses,
    boxes,
    depths,
    ANTIALIASED: tl.constexpr,
):
    """Project splats at (X, Y, Z) in the camera and write those that are seen; the others get a depth of infinity."""
    z = tl.where(wanted, Z, 1.0)
    u, v = X / z, Y / z
    fx, fy = tl.load(camera + 12), tl.load(camera + 13)
    u_clamped, v_clamped = clamped_direction(camera, u, v)
    w, x, y, zq, _ = unit_quaternion(qw, qx, qy, qz)
    x0, x1, x2, y0, y1, y2, _, _, _ = screen_axes(camera, u_clamped, v_clamped, fx / z, fy / z, w, x, y, zq)
    v0, v1, v2 = tl.exp(2.0 * log_scale_0), tl.exp(2.0 * log_scale_1), tl.exp(2.0 * log_scale_2)
    _, _, _, area, cov_xx, cov_xy, cov_yy, det = covariance(
        v0, v1, v2, x0, x1, x2, y0, y1, y2, low_pass_at(camera, u, v, z)
    )
    if ANTIALIASED:
        opacity = opacity * tl.sqrt(tl.maximum(area / det, COMPENSATION_MIN_2))
    reach = tl.maximum(2.0 * tl.log(255.0 * tl.maximum(opacity, 1e-30)), 0.0)
    half_x, half_y = tl.sqrt(reach * cov_xx), tl.sqrt(reach * cov_yy)
    mean_x, mean_y = fx * u + tl.load(camera + 14), fy * v + tl.load(camera + 15)
    width, height = tl.load(camera + 21), tl.load(camera + 22)

    # Written so that a splat with NaN anywhere fails.
    seen = wanted & (255.0 * opacity >= 1.0) & (cov_xx <= COVARIANCE_MAX) & (cov_yy <= COVARIANCE_MAX) & (det > 0.0)
    seen &= (mean_x + half_x > 0.0) & (mean_y + half_y > 0.0) & (mean_x - half_x < width) & (mean_y - half_y < height)
    tl.store(depths + row, Z.to(tl.float32), mask=seen)

    slope = -cov_xy / cov_yy
    t_by_x = tl.sqrt(cov_yy / det * EXPONENT_SCALE)
    at = splats + row * SPLAT
    tl.store(at, t_by_x.to(tl.float32), mask=seen)
    tl.store(at + 1, (t_by_x * slope).to(tl.float32), mask=seen)
    tl.store(at + 2, tl.sqrt(1.0 / cov_yy * EXPONENT_SCALE).to(tl.float32), mask=seen)
    tl.store(at + 3, (tl.log(opacity) * (2.0 * EXPONENT_SCALE)).to(tl.float32), mask=seen)
    tl.store(at + 4, red, mask=seen)
    tl.store(at + 5, green, mask=seen)
    tl.store(at + 6, blue, mask=seen)
    tl.store(at + 7, Z.to(tl.float32), mask=seen)
    at = places + row * PLACE
    tl.store(at, mean_x, mask=seen)
    tl.store(at + 1, mean_y, mask=seen)
    tl.store(at + 2, slope, mask=seen)

    # Covers the rounding to float32 of what follows; a pixel too many costs time only.
    slack = 1e-3 + 1e-6 * (tl.abs(mean_x) + tl.abs(mean_y) * (1.0 + tl.abs(slope)) + half_x + half_y)
    at = ellipses + row * ELLIPSE
    tl.store(at, mean_x.to(tl.float32), mask=seen)
    tl.store(at + 1, mean_y.to(tl.float32), mask=seen)
    tl.store(at + 2, (-slope).to(tl.float32), mask=seen)
    tl.store(at + 3, tl.sqrt(det / cov_yy).to(tl.float32), mask=seen)
    tl.store(at + 4, reach.to(tl.float32), mask=seen)
    tl.store(at + 5, (1.0 / cov_yy).to(tl.float32), mask=seen)
    tl.store(at + 6, (cov_xy * tl.sqrt(reach / cov_xx)).to(tl.float32), mask=seen)
    tl.store(at + 7, slack.to(tl.float32), mask=seen)
    at = boxes + row * 4
    tl.store(at, tl.ceil(tl.maximum(mean_x - half_x - 0.5 - slack, 0.0)).to(tl.int32), mask=seen)
    tl.store(at + 1, tl.floor(tl.minimum(mean_x + half_x - 0.5 + slack, width - 1.0)).to(tl.int32), mask=seen)
    tl.store(at + 2, tl.ceil(tl.maximum(mean_y - half_y - 0.5 - slack, 0.0)).to(tl.int32), mask=seen)
    tl.store(at + 3, tl.floor(tl.minimum(mean_y + half_y - 0.5 + slack, height - 1.0)).to(tl.int32), mask=seen)


@triton.jit
def project_statics(
    means,
    log_scales,
    quats,
    opacity_logits,
    rgb,
    count,
    camera,
    splats,
    places,
    ellipses,
    boxes,
    depths,
    tally,
    ANTIALIASED: tl.constexpr,
    BLOCK: tl.constexpr,
):
    """Rows 0 to `count` of the outputs; the first number of `tally` counts blocks with a parameter that is refused."""
    row = tl.program_id(0) * BLOCK + tl.arange(0, BLOCK)
    mask = row < count
    fine = all_finite(means, row, mask, 3, 4, FLOAT_MAX) & all_finite(log_scales, row, mask, 3, 4, FLOAT_MAX)
    fine &= all_finite(quats, row, mask, 4, 4, FLOAT_MAX) & all_finite(opacity_logits, row, mask, 1, 1, FLOAT_MAX)
    fine &= all_finite(rgb, row, mask, 3, 4, COLOUR_MAX)
    if tl.min(fine.to(tl.int32), axis=0) == 0:
        tl.atomic_add(tally, 1)
    opacity = sigmoid(tl.load(opacity_logits + row, mask=mask, other=0.0).to(tl.float64))
    mx, my, mz = load3(means, row * 3, mask)
    X, Y, Z = camera_space(camera, mx, my, mz)
    wanted = mask & (255.0 * opacity >= 1.0) & (tl.load(camera + 16) <= Z) & (Z <= DEPTH_MAX)
    s0, s1, s2 = load3(log_scales, row * 3, wanted)
    qw, qx, qy, qz = load4(quats, row * 4, wanted)
    red = tl.load(rgb + row * 3, mask=wanted, other=0.0)
    green = tl.load(rgb + row * 3 + 1, mask=wanted, other=0.0)
    blue = tl.load(rgb + row * 3 + 2, mask=wanted, other=0.0)
    project_and_store(
        row,
        wanted,
        X,
        Y,
        Z,
        s0,
        s1,
        s2,
        qw,
        qx,
        qy,
        qz,
        opacity,
        red,
        green,
        blue,
        camera,
        splats,
        places,
        ellipses,
        boxes,
        depths,
        ANTIALIASED,
    )


@triton.jit
def project_dynamics(
    motion,
    rotation,
    log_scales,
    opacity_logits,
    time_centers,
    time_log_precisions,
    rgb,
    count,
    first,
    camera,
    splats,
    places,
    ellipses,
    boxes,
    depths,
    tally,
    COEFFICIENTS: tl.constexpr,
    ANTIALIASED: tl.constexpr,
    BLOCK: tl.constexpr,
):
    """Rows `first` to `first + count` of the outputs; of dead splats nothing but their lives is looked at."""
    row = tl.program_id(0) * BLOCK + tl.arange(0, BLOCK)
    mask = row < count
    logit = tl.load(opacity_logits + row, mask=mask, other=0.0)
    center = tl.load(time_centers + row, mask=mask, other=0.0)
    log_precision = tl.load(time_log_precisions + row, mask=mask, other=0.0)
    fine = (tl.abs(logit) <= FLOAT_MAX) & (tl.abs(center) <= FLOAT_MAX) & (tl.abs(log_precision) <= FLOAT_MAX)
    d, _, left = fade(center.to(tl.float64), log_precision.to(tl.float64), tl.load(camera + 23))
    opacity = sigmoid(logit.to(tl.float64)) * left
    alive = mask & (255.0 * opacity >= 1.0)
    width: tl.constexpr = 3 * COEFFICIENTS  # numbers in a row of the motion
    fine &= all_finite(motion, row, alive, width, 16 if width <= 16 else 32, FLOAT_MAX)
    fine &= all_finite(rotation, row, alive, 8, 8, FLOAT_MAX)
    fine &= all_finite(log_scales, row, alive, 3, 4, FLOAT_MAX) & all_finite(rgb, row, alive, 3, 4, COLOUR_MAX)
    if tl.min(fine.to(tl.int32), axis=0) == 0:
        tl.atomic_add(tally, 1)
    mx = moved(motion, row * width, d, alive, COEFFICIENTS)
    my = moved(motion, row * width + 1, d, alive, COEFFICIENTS)
    X, Y, Z = camera_space(camera, mx, my, moved(motion, row * width + 2, d, alive, COEFFICIENTS))
    wanted = alive & (tl.load(camera + 16) <= Z) & (Z <= DEPTH_MAX)
    s0, s1, s2 = load3(log_scales, row * 3, wanted)
    qw, qx, qy, qz = load4(rotation, row * 8, wanted)
    rw, rx, ry, rz = load4(rotation, row * 8 + 4, wanted)
    red = tl.load(rgb + row * 3, mask=wanted, other=0.0)
    green = tl.load(rgb + row * 3 + 1, mask=wanted, other=0.0)
    blue = tl.load(rgb + row * 3 + 2, mask=wanted, other=0.0)
    project_and_store(
        row + first,
        wanted,
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
        opacity,
        red,
        green,
        blue,
        camera,
        splats,
        places,
        ellipses,
        boxes,
        depths,
        ANTIALIASED,
    )
