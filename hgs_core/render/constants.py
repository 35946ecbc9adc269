"""The constants of the rasterizer, shared by all backends; docs/numerics.md derives and explains them."""

__all__ = ["ALPHA_MAX", "ALPHA_MIN", "FRUSTUM_MARGIN", "LOW_PASS", "TILE", "TRANSMITTANCE_MIN"]

TILE = 16  # pixels; side of a tile
LOW_PASS = 0.3  # pixels^2; added to the screen covariance so that no splat is thinner than about a pixel
ALPHA_MIN = 1 / 255  # less cannot change an 8-bit pixel
ALPHA_MAX = 0.99  # keeps 1 - alpha away from zero in the backward pass
TRANSMITTANCE_MIN = 1e-4  # a pixel is finished before the splat that would take it to this or below
FRUSTUM_MARGIN = 0.3  # half field-of-view tangents beyond the image at which the Jacobian's direction is clamped
