"""Quaternions in three or four bytes, as SPZ files of version 2, and of 3 and 4, hold them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles

__all__ = ["pack_first_three", "pack_smallest_three", "unpack_first_three", "unpack_smallest_three"]

_NINE_BITS = 511 * 2**0.5  # 511 stands for the root of a half, the limit of all but the largest component


def pack_first_three(xyzw: Doubles) -> NDArray[np.uint8]:
    """Pack unit quaternions [N, 4] into x, y, z of eight bits each [N, 3], of the sign with which w is positive."""
    numbers = xyzw[:, :3] * np.where(xyzw[:, 3:] < 0, -127.5, 127.5) + 127.5
    return np.asarray(np.clip(np.floor(numbers + 0.5), 0, 255), np.uint8)


def unpack_first_three(packed: NDArray[np.uint8]) -> Doubles:
    """Return the quaternions [N, 4] of bytes [N, 3]."""
    vector = packed / 127.5 - 1
    w = np.sqrt(np.maximum(0.0, 1 - (vector**2).sum(axis=1, keepdims=True)))
    return np.concatenate([vector, w], axis=1)


def pack_smallest_three(xyzw: Doubles) -> NDArray[np.uint8]:
    """Pack unit quaternions [N, 4]: two bits name the largest component, the others have a sign and nine bits."""
    rows = np.arange(len(xyzw))
    largest = np.abs(xyzw).argmax(axis=1)
    signed = xyzw * np.where(xyzw[rows, largest] < 0, -1.0, 1.0)[:, None]
    packed = largest.astype(np.uint32)
    for component in range(4):
        number = (np.abs(signed[:, component]) * _NINE_BITS + 0.5).astype(np.uint32)
        number |= (signed[:, component] < 0).astype(np.uint32) << np.uint32(9)
        packed = np.where(component == largest, packed, packed << np.uint32(10) | number)
    return np.asarray(packed, "<u4").view(np.uint8).reshape(-1, 4)


def unpack_smallest_three(packed: NDArray[np.uint8]) -> Doubles:
    """Return the quaternions [N, 4] of bytes [N, 4]."""
    rest = np.ascontiguousarray(packed).view("<u4")[:, 0].copy()
    largest = (rest >> np.uint32(30)).astype(np.intp)
    xyzw = np.zeros((len(packed), 4))
    for component in (3, 2, 1, 0):
        stored = component != largest
        value = (rest & np.uint32(511)) / _NINE_BITS
        xyzw[:, component] = np.where(stored, np.where(rest & np.uint32(512), -value, value), 0.0)
        rest = np.where(stored, rest >> np.uint32(10), rest)
    xyzw[np.arange(len(packed)), largest] = np.sqrt(np.maximum(0.0, 1 - (xyzw**2).sum(axis=1)))
    return xyzw
