"""Tables of 256 numbers that stand for many: the smallest mean square error of a splat's scales, of its colours."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles, Floats

__all__ = ["ENTRIES", "codebook"]

ENTRIES = 256
_BINS = 4096  # bins of the histogram behind the first table
_ROUNDS = 30


def codebook(values: Floats) -> tuple[Doubles, NDArray[np.uint8]]:
    """Return a rising table [256], and for each of `values` the number of its nearest entry.

    Entries begin as dense as the cube root of the values' density, the optimum of fine tables, and then move to the
    means of their values, as often as helps (Lloyd). Values that are 256 or fewer are kept as they are.
    """
    plain = np.asarray(values, np.float64).ravel()
    found = np.unique(plain)
    if len(found) <= ENTRIES:
        table = np.concatenate([found, np.full(ENTRIES - len(found), found[-1] if len(found) else 0.0)])
        return table, np.searchsorted(found, plain).astype(np.uint8).reshape(values.shape)
    ordered = np.sort(plain)
    sums = np.concatenate([[0.0], np.cumsum(ordered)])
    table = _dense(ordered)
    for _ in range(_ROUNDS):
        edges = np.concatenate([[0], np.searchsorted(ordered, (table[1:] + table[:-1]) / 2), [len(ordered)]])
        counts = np.diff(edges)
        table = np.where(counts > 0, np.diff(sums[edges]) / np.maximum(counts, 1), table)
    table = np.sort(table)
    numbers = np.searchsorted((table[1:] + table[:-1]) / 2, plain)
    return table, numbers.astype(np.uint8).reshape(values.shape)


def _dense(ordered: Doubles) -> Doubles:
    """Return a table that is dense where values are, its ends the least and the largest."""
    heights, edges = np.histogram(ordered, _BINS)
    share = np.concatenate([[0.0], np.cumsum(np.cbrt(heights))])
    return np.asarray(np.interp(np.linspace(0, share[-1], ENTRIES), share, edges))
