from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hgs_core.base import morton

coordinate = st.integers(0, (1 << 24) - 1)
grids = st.lists(st.tuples(coordinate, coordinate, coordinate), min_size=1, max_size=40)


def code_of(point: tuple[int, int, int]) -> int:
    """The reference: bit k of axis a is bit 3 k + a of a Python integer."""
    return sum((point[axis] >> k & 1) << (3 * k + axis) for k in range(24) for axis in range(3))


@given(grids)
def test_limbs_are_the_code(points: list[tuple[int, int, int]]) -> None:
    limbs = morton.interleave(np.array(points, np.uint32))
    assert [sum(int(x) << 24 * i for i, x in enumerate(row)) for row in limbs] == [code_of(p) for p in points]


@given(grids)
def test_order_sorts_the_codes(points: list[tuple[int, int, int]]) -> None:
    order = morton.order(morton.interleave(np.array(points, np.uint32)))
    assert [code_of(points[i]) for i in order] == sorted(map(code_of, points))


@given(grids, st.sampled_from([21, 24]))
def test_grid_points_come_back_from_the_planes_of_differences(points: list[tuple[int, int, int]], bits: int) -> None:
    grid = np.array(points, np.uint32) & np.uint32((1 << bits) - 1)
    limbs = morton.interleave(grid)
    order = morton.order(limbs)
    steps = morton.differences(limbs[order])
    assert (steps < 1 << 24).all()
    planes = np.array([np.frombuffer(plane, np.uint8) for plane in morton.to_planes(steps, bits)])
    np.testing.assert_array_equal(morton.grid_points(planes, bits).T, grid[order])


@pytest.mark.parametrize("bits", [3, 8, 20, 21, 22, 24])
def test_codes_beyond_the_grid_are_refused(bits: int) -> None:
    planes = np.full((-(-3 * bits // 8), 3), 255, np.uint8)
    with pytest.raises(ValueError, match="beyond the grid"):
        morton.grid_points(planes, bits)
