"""Connected parts and components, against flood fills."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from hgs_core.decompose.components import Box, component_boxes, component_labels


def flooded(mask: np.ndarray) -> list[tuple[int, Box]]:
    """Independent reference: area and box of every part, by flood fill."""
    left = {(int(y), int(x)) for y, x in np.argwhere(mask)}
    parts = []
    while left:
        front, part = [left.pop()], []
        while front:
            y, x = front.pop()
            part.append((y, x))
            for step in ((y - 1, x), (y + 1, x), (y, x - 1), (y, x + 1)):
                if step in left:
                    left.remove(step)
                    front.append(step)
        ys, xs = zip(*part, strict=True)
        parts.append((len(part), (min(xs), min(ys), max(xs) + 1, max(ys) + 1)))
    return parts


@pytest.mark.parametrize("density", [0.1, 0.4, 0.6, 0.9])
def test_parts_are_those_of_a_flood_fill(density: float) -> None:
    mask = np.random.default_rng(int(10 * density)).random((30, 41)) < density
    expected = flooded(mask)
    found = component_boxes(mask, 10_000, 1)
    assert sorted(found) == sorted(box for _, box in expected)
    areas = {box: area for area, box in expected}
    if len(areas) == len(expected):
        assert [areas[box] for box in found] == sorted(areas.values(), reverse=True)


def test_only_the_largest_are_returned() -> None:
    mask = np.zeros((20, 20), bool)
    mask[1:4, 1:4], mask[10:18, 10:12], mask[6, 18] = True, True, True
    assert component_boxes(mask, 2, 1) == [(10, 10, 12, 18), (1, 1, 4, 4)]
    assert component_boxes(mask, 5, 2) == [(10, 10, 12, 18), (1, 1, 4, 4)]


def test_an_empty_mask_has_none() -> None:
    assert component_boxes(np.zeros((5, 7), bool), 3, 1) == []


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
