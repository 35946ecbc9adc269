"""Morton codes (Z-order) of points on an integer grid: the order in which splats are stored, and how they are coded.

A code of up to 72 bits is kept as three 24-bit limbs, low limb first: limb i interleaves bits 8i..8i+7 of x, y and z,
x lowest. Sorting by the code puts neighbours in space next to each other, and the differences of sorted codes
are small. Decoding takes a shorter way where codes fit into 63 bits.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["LIMBS", "LIMB_BITS", "differences", "grid_points", "interleave", "order", "to_planes"]

LIMBS = 3
LIMB_BITS = 24
LIMB_MASK = np.uint64((1 << LIMB_BITS) - 1)
WORD_BITS = 21  # bits of a coordinate; three fit into a code of 63 bits
DIGIT = 15  # bits of a code that are looked up at once: five of each coordinate

Limbs = NDArray[np.uint64]  # [N, 3]

_SPREAD = np.array([sum((b >> i & 1) << 3 * i for i in range(8)) for b in range(256)], np.uint64)

# A digit's coordinates, x in bits 0 to 4, y in 21 to 25, z in 42 to 46.
_GATHER = np.bitwise_or.reduce(
    [
        ((np.arange(1 << DIGIT, dtype=np.uint64) >> np.uint64(3 * k + axis)) & np.uint64(1))
        << np.uint64(WORD_BITS * axis + k)
        for k in range(DIGIT // 3)
        for axis in range(3)
    ]
)
_AXES = np.array([[WORD_BITS * axis] for axis in range(3)], np.uint64)


def interleave(grid: NDArray[np.uint32]) -> Limbs:
    """Return the codes of grid points [N, 3], each coordinate below 2^24."""
    parts = [(grid >> np.uint32(8 * limb)) & np.uint32(255) for limb in range(LIMBS)]
    return np.stack([_SPREAD[p[:, 0]] | _SPREAD[p[:, 1]] << 1 | _SPREAD[p[:, 2]] << 2 for p in parts], axis=1)


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


def to_planes(steps: Limbs, bits: int) -> list[bytes]:
    """Split differences of codes of `bits` per coordinate into byte planes, low byte first."""
    return [(steps[:, p // 3] >> np.uint64(8 * (p % 3))).astype(np.uint8).tobytes() for p in range((3 * bits + 7) // 8)]


def grid_points(planes: NDArray[np.uint8], bits: int) -> NDArray[np.uint32]:
    """Add up differences in byte planes [P, N]; return the coordinates x, y and z, [3, N].

    Raises:
        ValueError: a code reaches 2^(3 bits).
    """
    return _points_of_words(planes, bits) if bits <= WORD_BITS else _points_of_limbs(planes, bits)


def _points_of_words(planes: NDArray[np.uint8], bits: int) -> NDArray[np.uint32]:
    used, count = planes.shape
    words = np.zeros((count, 8), np.uint8)
    words[:, :used] = planes.T
    codes = np.cumsum(words.view("<u8")[:, 0], dtype=np.uint64)
    # One difference is below 2^(8 used): the sum of few fits, and one that does not is smaller than the one before.
    fits = 8 * used + count.bit_length() <= 64
    if int(codes[-1]) >> 3 * bits or (not fits and (codes[1:] < codes[:-1]).any()):
        raise ValueError("beyond the grid")
    places = codes.view(np.int64)  # 63 bits at most; the type of indices, so that none is converted
    low = (1 << DIGIT) - 1
    packed = _GATHER.take(places & low)
    for digit in range(1, -(-3 * bits // DIGIT)):
        packed |= _GATHER.take(places >> DIGIT * digit & low) << np.uint64(DIGIT // 3 * digit)
    points: NDArray[np.uint64] = packed >> _AXES
    points &= np.uint64((1 << WORD_BITS) - 1)
    return points.astype(np.uint32)


def _points_of_limbs(planes: NDArray[np.uint8], bits: int) -> NDArray[np.uint32]:
    steps = np.zeros((planes.shape[1], LIMBS), np.uint64)
    for p, plane in enumerate(planes):
        steps[:, p // 3] |= plane.astype(np.uint64) << np.uint64(8 * (p % 3))
    limbs = np.cumsum(steps, axis=0, dtype=np.uint64)
    for limb in range(LIMBS - 1):
        limbs[:, limb + 1] += limbs[:, limb] >> np.uint64(LIMB_BITS)
        limbs[:, limb] &= LIMB_MASK
    # The codes ascend, so the last one shows whether any is too large.
    if sum(int(x) << LIMB_BITS * i for i, x in enumerate(limbs[-1])) >> 3 * bits:
        raise ValueError("beyond the grid")
    points = np.zeros((3, len(limbs)), np.uint32)
    for limb in range(LIMBS):
        for axis in range(3):
            for bit in range(8):
                taken = limbs[:, limb] >> np.uint64(3 * bit + axis) & np.uint64(1)
                points[axis] |= taken.astype(np.uint32) << np.uint32(8 * limb + bit)
    return points
