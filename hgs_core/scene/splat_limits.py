"""The largest numbers of splats that can be drawn and encoded; every maker of splats keeps to them."""

from __future__ import annotations

__all__ = ["LARGEST_COLOUR", "LARGEST_COORDINATE", "LARGEST_LOG_SCALE"]

LARGEST_COORDINATE = 1e30  # world units
LARGEST_LOG_SCALE = 30.0
LARGEST_COLOUR = 8.0  # either sign; training keeps colours near [0, 1]
