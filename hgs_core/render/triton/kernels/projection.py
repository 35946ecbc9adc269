"""From splats in space to ellipses on the screen in float64 (docs/numerics.md, "Projection"): shared by forward and
backward.

Everything per splat costs little beside the pixels, so nothing of it is computed in float32.
"""

import triton
import triton.language as tl

from hgs_core.render.triton.kernels.constants import LOW_PASS, QUATERNION_MIN, TIME_LOG_PRECISION_MAX

__all__ = [
    "camera_space",
    "clamped_direction",
    "covariance",
    "fade",
    "load3",
    "load4",
    "low_pass_at",
    "moved",
    "screen_axes",
    "sigmoid",
    "unit_quaternion",
    "velocity",
]


@triton.jit
def load3(array, at, mask):
    """Three consecutive values from `at`, as float64."""
    x = tl.load(array + at, mask=mask, other=0.0).to(tl.float64)
    y = tl.load(array + at + 1, mask=mask, other=0.0).to(tl.float64)
    z = tl.load(array + at + 2, mask=mask, other=0.0).to(tl.float64)
    return x, y, z


@triton.jit
def load4(array, at, mask):
    """Four consecutive values from `at`, as float64."""
    w = tl.load(array + at, mask=mask, other=0.0).to(tl.float64)
    x, y, z = load3(array, at + 1, mask)
    return w, x, y, z


@triton.jit
def sigmoid(x):
    """1 / (1 + exp(-x))."""
    return 1.0 / (1.0 + tl.exp(-x))


@triton.jit
def fade(center, log_precision, time):
    """Time from the centre, the precision, and how much of the peak opacity is left."""
    d = time - center
    precision = tl.exp(tl.minimum(log_precision, TIME_LOG_PRECISION_MAX))
    return d, precision, tl.exp(-precision * d * d)


@triton.jit
def moved(array, at, d, mask, COEFFICIENTS: tl.constexpr):
    """One coordinate of the motion polynomial [COEFFICIENTS, 3] with its constant at `at`."""
    place = tl.load(array + at + 3 * (COEFFICIENTS - 1), mask=mask, other=0.0).to(tl.float64)
    for k in tl.static_range(2, COEFFICIENTS + 1):
        place = tl.load(array + at + 3 * (COEFFICIENTS - k), mask=mask, other=0.0).to(tl.float64) + d * place
    return place


@triton.jit
def velocity(array, at, d, mask, COEFFICIENTS: tl.constexpr):
    """The derivative by d of the result of `moved`."""
    change = (COEFFICIENTS - 1.0) * tl.load(array + at + 3 * (COEFFICIENTS - 1), mask=mask, other=0.0).to(tl.float64)
    for k in tl.static_range(2, COEFFICIENTS):
        m = tl.load(array + at + 3 * (COEFFICIENTS - k), mask=mask, other=0.0).to(tl.float64)
        change = (COEFFICIENTS - k) * m + d * change
    return change


@triton.jit
def unit_quaternion(w, x, y, z):
    """The quaternion at unit length and the inverse of its norm; the identity and 0 for one without a direction."""
    largest = tl.maximum(tl.maximum(tl.abs(w), tl.abs(x)), tl.maximum(tl.abs(y), tl.abs(z)))
    safe = tl.where(largest > 0.0, largest, 1.0)
    w, x, y, z = w / safe, x / safe, y / safe, z / safe
    root = tl.sqrt(w * w + x * x + y * y + z * z)
    usable = largest * root >= QUATERNION_MIN
    inverse = tl.where(usable, 1.0 / tl.where(usable, root, 1.0), 0.0)
    return tl.where(usable, w * inverse, 1.0), x * inverse, y * inverse, z * inverse, inverse / safe


@triton.jit
def camera_space(camera, x, y, z):
    """R p + t."""
    return (
        tl.load(camera) * x + tl.load(camera + 1) * y + tl.load(camera + 2) * z + tl.load(camera + 9),
        tl.load(camera + 3) * x + tl.load(camera + 4) * y + tl.load(camera + 5) * z + tl.load(camera + 10),
        tl.load(camera + 6) * x + tl.load(camera + 7) * y + tl.load(camera + 8) * z + tl.load(camera + 11),
    )


@triton.jit
def clamped_direction(camera, u, v):
    """The direction at which the Jacobian is taken."""
    u = tl.minimum(tl.maximum(u, tl.load(camera + 17)), tl.load(camera + 18))
    v = tl.minimum(tl.maximum(v, tl.load(camera + 19)), tl.load(camera + 20))
    return u, v


@triton.jit
def screen_axis(camera, u, v, jx, jy, a, b, c):
    """The screen projection of a unit axis (a, b, c) of a splat, and the axis's z in the camera."""
    across, down, along = camera_turned(camera, a, b, c)
    return jx * (across - u * along), jy * (down - v * along), along


@triton.jit
def camera_turned(camera, a, b, c):
    """R v."""
    return (
        tl.load(camera) * a + tl.load(camera + 1) * b + tl.load(camera + 2) * c,
        tl.load(camera + 3) * a + tl.load(camera + 4) * b + tl.load(camera + 5) * c,
        tl.load(camera + 6) * a + tl.load(camera + 7) * b + tl.load(camera + 8) * c,
    )


@triton.jit
def screen_axes(camera, u, v, jx, jy, w, x, y, z):
    """Jacobian x camera rotation x splat rotation: the x and y of e_0, e_1, e_2, and the axes' z in the camera."""
    x0, y0, z0 = screen_axis(
        camera, u, v, jx, jy, 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)
    )
    x1, y1, z1 = screen_axis(
        camera, u, v, jx, jy, 2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)
    )
    x2, y2, z2 = screen_axis(
        camera, u, v, jx, jy, 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)
    )
    return x0, x1, x2, y0, y1, y2, z0, z1, z2


@triton.jit
def low_pass_at(camera, u, v, z):
    """The variance that is added to splats in the direction (u, v) at depth z, pixels squared, LOW_PASS at least."""
    larger = tl.load(camera + 24) * u + tl.load(camera + 25) * v + tl.load(camera + 26) + tl.load(camera + 27) / z
    larger = tl.maximum(larger, 1.0)
    return larger * larger * LOW_PASS


@triton.jit
def covariance(v0, v1, v2, x0, x1, x2, y0, y1, y2, low_pass):
    """Screen covariance C of variances v_j along e_j = (x_j, y_j), without a difference in which needles lose digits.

    Returns the cross products e_1 x e_2, e_2 x e_0 and e_0 x e_1, det C0, C_xx, C_xy, C_yy and det C, the latter four
    with the low-pass.
    """
    c0 = x1 * y2 - y1 * x2
    c1 = x2 * y0 - y2 * x0
    c2 = x0 * y1 - y0 * x1
    area = v1 * v2 * c0 * c0 + v2 * v0 * c1 * c1 + v0 * v1 * c2 * c2
    xx = v0 * x0 * x0 + v1 * x1 * x1 + v2 * x2 * x2
    xy = v0 * x0 * y0 + v1 * x1 * y1 + v2 * x2 * y2
    yy = v0 * y0 * y0 + v1 * y1 * y1 + v2 * y2 * y2
    det = area + (xx + yy) * low_pass + low_pass * low_pass
    return c0, c1, c2, area, xx + low_pass, xy, yy + low_pass, det
