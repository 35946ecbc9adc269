"""The constants of docs/numerics.md as kernels see them, and the layouts of arrays passed between kernels."""

import math

import triton.language as tl

from hgs_core.render import constants

__all__ = [
    "ALPHA_MAX",
    "CAMERA_LENGTH",
    "COLOUR_MAX",
    "COMPENSATION_MIN_2",
    "COVARIANCE_MAX",
    "DEPTH_MAX",
    "ELLIPSE",
    "EXPONENT_ROOT",
    "EXPONENT_SCALE",
    "FLOAT_MAX",
    "LOG2_ALPHA_MIN",
    "LOW_PASS",
    "PLACE",
    "QUATERNION_MIN",
    "SPLAT",
    "TERMS",
    "TILE",
    "TILE_PIXELS",
    "TIME_LOG_PRECISION_MAX",
    "TRANSMITTANCE_MIN",
]

TILE = tl.constexpr(constants.TILE)
TILE_PIXELS = tl.constexpr(constants.TILE**2)
LOW_PASS = tl.constexpr(constants.LOW_PASS)
LOG2_ALPHA_MIN = tl.constexpr(math.log2(constants.ALPHA_MIN))
ALPHA_MAX = tl.constexpr(constants.ALPHA_MAX)
TRANSMITTANCE_MIN = tl.constexpr(constants.TRANSMITTANCE_MIN)
COMPENSATION_MIN_2 = tl.constexpr(constants.COMPENSATION_MIN**2)
COVARIANCE_MAX = tl.constexpr(constants.COVARIANCE_MAX)
DEPTH_MAX = tl.constexpr(constants.DEPTH_MAX)
COLOUR_MAX = tl.constexpr(constants.COLOUR_MAX)
QUATERNION_MIN = tl.constexpr(constants.QUATERNION_MIN)
TIME_LOG_PRECISION_MAX = tl.constexpr(constants.TIME_LOG_PRECISION_MAX)
FLOAT_MAX = tl.constexpr(3.4028234663852886e38)
EXPONENT_SCALE = tl.constexpr(0.5 * math.log2(math.e))  # exponent of squares in round coordinates, base 2
EXPONENT_ROOT = tl.constexpr(math.sqrt(0.5 * math.log2(math.e)))

# Lengths of rows. `kernels.projection_forward` writes the first three, `kernels.compositing_backward` the last.
# float64: rotation 9, translation 3, fx, fy, cx, cy, near, u and v from and to, W, H, time, magnification 4
CAMERA_LENGTH = 28
SPLAT = tl.constexpr(8)  # float32: t by x, t by y, e by y, log2 opacity, red, green, blue, z
PLACE = tl.constexpr(4)  # float64: mean x, mean y, slope -C_xy / C_yy, nothing
ELLIPSE = tl.constexpr(8)  # float32, pixels: see `kernels.tile_lists.covered_tiles`
# float32: sums of h t, h e, h t^2, h t e, h e^2, red, green, blue, h, depth, |h t|, |h (t by y t + e by y e)|
TERMS = tl.constexpr(12)
