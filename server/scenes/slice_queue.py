"""Queue of slices ordered by time, with operations in O(log n) of the scene's slices."""

from __future__ import annotations

import copy
import math
from array import array
from collections.abc import Sequence

__all__ = ["SliceQueue"]

_ABSENT = -math.inf


class SliceQueue:
    """Indices of a scene's slices; full at first.

    A complete binary tree over the slices: a leaf is the end of its slice, or minus infinity while
    the slice is not queued; an inner node is the greater of its two children.
    """

    def __init__(self, ends: Sequence[float]) -> None:
        """Queue slices shown for times < `ends` (seconds); the last one also at its very end."""
        self._leaves = 1 << max(len(ends) - 1, 0).bit_length()
        self._ends = array("d", ends)
        if ends:
            self._ends[-1] = math.nextafter(ends[-1], math.inf)
        absent = self._leaves - len(ends)
        self._tree = array("d", [_ABSENT] * self._leaves) + self._ends + array("d", [_ABSENT] * absent)
        for node in range(self._leaves - 1, 0, -1):
            self._tree[node] = max(self._tree[2 * node], self._tree[2 * node + 1])

    def copy(self) -> SliceQueue:
        """Return an independent copy."""
        other = copy.copy(self)
        other._tree = self._tree[:]
        return other

    def grown(self, ends: Sequence[float]) -> SliceQueue:
        """Return a queue for more slices: the new ones are queued, the old ones only if they are here."""
        other = SliceQueue(ends)
        for index in range(len(self._ends)):
            if self._tree[self._leaves + index] == _ABSENT:
                other.discard(index)
        return other

    def add(self, index: int) -> None:
        """Queue the slice `index`, unless it is queued."""
        self._set(index, self._ends[index])

    def discard(self, index: int) -> None:
        """Remove the slice `index`, if it is queued."""
        self._set(index, _ABSENT)

    def next(self, time: float) -> int | None:
        """Return the first slice not over at `time`, in seconds, or else the first of all; None if empty."""
        index = self.first_shown_after(time)
        return self.first_shown_after(_ABSENT) if index is None else index

    def first_shown_after(self, time: float, begin: int = 0) -> int | None:
        """Return the first slice from index `begin` shown at a moment after `time`, or None."""
        if begin >= self._leaves:
            return None
        tree = self._tree
        node = self._leaves + begin
        # Up, to the right of `begin`, to a subtree with such a slice; then down to its leftmost one.
        while tree[node] <= time:
            while node & 1:
                node >>= 1
            if node == 0:
                return None
            node += 1
        while node < self._leaves:
            node *= 2
            if tree[node] <= time:
                node += 1
        return node - self._leaves

    def _set(self, index: int, value: float) -> None:
        tree = self._tree
        node = self._leaves + index
        tree[node] = value
        while node > 1:
            node >>= 1
            greater = max(tree[2 * node], tree[2 * node + 1])
            if tree[node] == greater:
                return
            tree[node] = greater
