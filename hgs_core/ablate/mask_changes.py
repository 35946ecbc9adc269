"""Damage to motion masks: too wide, too narrow, and wrong."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from hgs_core.base.arrays import Mask
from hgs_core.decompose.components import component_labels
from hgs_core.decompose.morphology import dilate

__all__ = ["Mask", "MaskChange", "blobs_added", "components_dropped", "eroded", "grown_to_share"]

"""[H, W], True = moves."""

MaskChange = Callable[[Mask, np.random.Generator], Mask]
"""Returns a changed mask; the generator is that of the picture."""


def grown_to_share(mask: Mask, share: float) -> Mask:
    """Dilate by the fewest pixels after which at least `share` of the picture moves.

    A mask that is that large already stays as it is, and so does an empty one, which cannot grow.
    """
    if mask.mean() >= share or not mask.any():
        return mask
    narrow, step = mask, 1  # `narrow` is always short of the share
    while (wide := dilate(narrow, step)).mean() < share:
        narrow, step = wide, 2 * step
    while step > 1:
        step //= 2
        if (wide := dilate(narrow, step)).mean() < share:
            narrow = wide
    return dilate(narrow, 1)


def eroded(mask: Mask, radius: int) -> Mask:
    """Clear every pixel that has a clear pixel of the picture within `radius` rows and columns."""
    return np.asarray(~dilate(~mask, radius))


def components_dropped(mask: Mask, generator: np.random.Generator, chance: float) -> Mask:
    """Clear each connected component with the given probability."""
    labels = component_labels(mask)
    kept = generator.random(int(labels.max(initial=0)) + 1) >= chance
    kept[0] = False
    return np.asarray(kept[labels])


def blobs_added(mask: Mask, generator: np.random.Generator, count: int, share: float) -> Mask:
    """Set `count` equal discs at random places; without overlaps they would be `share` of the picture."""
    height, width = mask.shape
    squared = share * height * width / (count * math.pi)
    rows, columns = np.arange(height)[:, None], np.arange(width)
    result = mask.copy()
    for y, x in generator.random((count, 2)) * (height, width):
        result |= (rows + 0.5 - y) ** 2 + (columns + 0.5 - x) ** 2 <= squared
    return result
