"""sRGB colours and the light they stand for (IEC 61966-2-1)."""

from __future__ import annotations

import numpy as np

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.interchange.changes import Action, Change

__all__ = ["srgb_replaced", "to_light", "to_srgb"]


def to_light(rgb: Doubles | Floats) -> Doubles:
    """Return sRGB colours from 0 to 1 as linear ones."""
    return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)


def to_srgb(light: Doubles) -> Doubles:
    """Return linear colours as sRGB ones, negative ones as 0."""
    light = np.maximum(light, 0)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def srgb_replaced(count: int) -> Change:
    """Return the change of all splats that `to_srgb` is."""
    reason = "linear colours by sRGB ones, splat by splat: where splats blend, light differs"
    return Change(Action.REPLACED, "colour", count, count, reason)
