"""Connected parts, against a flood fill."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.decompose.components import Box, component_boxes


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
