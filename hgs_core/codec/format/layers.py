"""The layers of a scene's chunks: the base of a picture, and its refinements (docs/format.md, "Layers")."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["SLICE_PART", "STATIC_PART", "layers"]

STATIC_PART = 4  # the base of the static chunks has at least a fourth of their bytes
SLICE_PART = 3  # and that of a slice's a third


def layers(sizes: Sequence[int], part: int) -> list[int]:
    """Return the layer of every chunk of a list, from the chunks' sizes in bytes.

    Layer 0, the base, is the shortest beginning of the list with at least 1 / `part` of its bytes; every chunk after it
    is a layer of its own, 1, 2, ...

    Example:
        >>> layers([30, 30, 20, 20], SLICE_PART)
        [0, 0, 1, 2]
    """
    total, before, base = sum(sizes), 0, 0
    while part * before < total:
        before += sizes[base]
        base += 1
    return [max(0, place - base + 1) for place in range(len(sizes))]
