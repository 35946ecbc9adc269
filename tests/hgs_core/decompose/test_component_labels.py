"""Connected components, against flood filling."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from hgs_core.decompose.components import component_labels


def flood_fill(mask: np.ndarray) -> np.ndarray:
    """Label pixel by pixel, in reading order of the components' first pixels."""
    labels = np.zeros(mask.shape, int)
    for start in zip(*np.nonzero(mask), strict=True):
        if labels[start]:
            continue
        labels[start], waiting = labels.max() + 1, [start]
        while waiting:
            y, x = waiting.pop()
            around = np.s_[max(0, y - 1) : y + 2, max(0, x - 1) : x + 2]
            corner = np.maximum((y - 1, x - 1), 0)
            for pixel in np.argwhere(mask[around] & (labels[around] == 0)) + corner:
                labels[tuple(pixel)] = labels[start]
                waiting.append(tuple(pixel))
    return labels


@settings(deadline=None)
@given(arrays(bool, st.tuples(st.integers(1, 12), st.integers(1, 12))))
def test_components_are_those_of_flood_filling(mask: np.ndarray) -> None:
    np.testing.assert_array_equal(component_labels(mask), flood_fill(mask))


def test_a_spiral_is_one_component() -> None:
    spiral = np.zeros((41, 41), bool)
    for ring in range(0, 20, 2):
        spiral[ring, max(0, ring - 2) : 41 - ring] = True
        spiral[ring : 41 - ring, 40 - ring] = True
        spiral[40 - ring, ring : 41 - ring] = True
        spiral[ring + 2 : 41 - ring, ring] = True
    assert component_labels(spiral).max() == 1
    np.testing.assert_array_equal(component_labels(spiral), flood_fill(spiral))
