"""The constants of the rasterizer, shared by all backends; docs/numerics.md derives and explains them."""

from hgs_core.scene.low_pass import COMPENSATION_MIN, LOW_PASS

__all__ = [
    "ALPHA_MAX",
    "ALPHA_MIN",
    "COLOUR_MAX",
    "COMPENSATION_MIN",
    "COVARIANCE_MAX",
    "DEPTH_MAX",
    "ENTRIES_MAX",
    "FRUSTUM_MARGIN",
    "LOW_PASS",
    "MAGNIFICATION_SLACK",
    "QUATERNION_MIN",
    "TILE",
    "TIME_LOG_PRECISION_MAX",
    "TRANSMITTANCE_MIN",
]

TILE = 16  # pixels; side of a tile
MAGNIFICATION_SLACK = 1 - 2**-12  # factor below 1: rounding magnifies nothing in a picture that made the scene
ALPHA_MIN = 1 / 255  # less cannot change an 8-bit pixel
ALPHA_MAX = 0.99  # keeps 1 - alpha away from zero in the backward pass
TRANSMITTANCE_MIN = 1e-4  # a pixel is finished before the splat that would take it to this or below
FRUSTUM_MARGIN = 0.3  # half field-of-view tangents beyond the image at which the Jacobian's direction is clamped
COVARIANCE_MAX = 1e18  # pixels^2; a splat that spreads further is not drawn: its determinant must fit in a float32
COLOUR_MAX = 1e18  # magnitude of a colour; a sum of products of more with gradients may leave float32
DEPTH_MAX = 1e18  # world units; splats further away are not drawn, for the same reason
QUATERNION_MIN = 1e-12  # length below which a quaternion has no direction and stands for the identity
TIME_LOG_PRECISION_MAX = 80.0  # exp of more overflows float32; at 80 a splat already lives for one instant alone
ENTRIES_MAX = 2**31 - 1  # pairs of splats and tiles that 32-bit lists can count
