"""The low-pass filter of pictures and its compensation (docs/numerics.md, "Projection" and "Antialiasing")."""

from __future__ import annotations

__all__ = ["COMPENSATION_MIN", "LOW_PASS"]

LOW_PASS = 0.3  # pixels^2; added to the screen covariance so that no splat is thinner than about a pixel
COMPENSATION_MIN = 0.005  # smallest factor of the opacity in antialiased pictures: with less nothing would be left
