"""Morton codes (Z-order) of points on an integer grid: the order in which splats are stored, and how they are coded.

A code of up to 72 bits is kept as three 24-bit limbs, low limb first: limb i interleaves bits 8i..8i+7 of x, y and z,
x lowest. Sorting by the code puts neighbours in space next to each other, and the differences of sorted codes
are small.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["LIMBS", "LIMB_BITS", "accumulate", "deinterleave", "differences", "interleave", "order"]

LIMBS = 3
LIMB_BITS = 24
LIMB_MASK = np.uint64((1 << LIMB_BITS) - 1)

Limbs = NDArray[np.uint64]  # [N, 3]

_SPREAD = np.array([sum((b >> i & 1) << 3 * i for i in range(8)) for b in range(256)], np.uint64)


def interleave(grid: NDArray[np.uint32]) -> Limbs:
    """Return the codes of grid points [N, 3], each coordinate below 2^24."""
    parts = [(grid >> np.uint32(8 * limb)) & np.uint32(255) for limb in range(LIMBS)]
    return np.stack([_SPREAD[p[:, 0]] | _SPREAD[p[:, 1]] << 1 | _SPREAD[p[:, 2]] << 2 for p in parts], axis=1)


def deinterleave(limbs: Limbs) -> NDArray[np.uint32]:
    """Return the grid points [N, 3] of codes."""
    grid = np.zeros((len(limbs), 3), np.uint32)
    for limb in range(LIMBS):
        for axis in range(3):
            for bit in range(8):
                taken = limbs[:, limb] >> np.uint64(3 * bit + axis) & np.uint64(1)
                grid[:, axis] |= taken.astype(np.uint32) << np.uint32(8 * limb + bit)
    return grid


def order(limbs: Limbs) -> NDArray[np.intp]:
    """Return the stable order that sorts the codes."""
    return np.lexsort(tuple(limbs.T))


def differences(limbs: Limbs) -> Limbs:
    """Return each sorted code minus the one before it (the first minus zero), as limbs."""
    steps = np.diff(limbs.astype(np.int64), axis=0, prepend=np.zeros((1, LIMBS), np.int64))
    for limb in range(LIMBS - 1):
        borrow = steps[:, limb] < 0
        steps[borrow, limb] += 1 << LIMB_BITS
        steps[borrow, limb + 1] -= 1
    if (steps[:, -1] < 0).any():
        raise ValueError("the codes are not sorted")
    return steps.astype(np.uint64)


def accumulate(steps: Limbs) -> Limbs:
    """Undo `differences`. The top limb is not reduced, so that the caller can see an overflow."""
    limbs = np.cumsum(steps, axis=0, dtype=np.uint64)
    for limb in range(LIMBS - 1):
        limbs[:, limb + 1] += limbs[:, limb] >> np.uint64(LIMB_BITS)
        limbs[:, limb] &= LIMB_MASK
    return limbs
