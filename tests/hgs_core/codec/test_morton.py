from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hgs_core.codec import morton

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
def test_deinterleave_undoes_interleave(points: list[tuple[int, int, int]]) -> None:
    grid = np.array(points, np.uint32)
    np.testing.assert_array_equal(morton.deinterleave(morton.interleave(grid)), grid)


@given(grids)
def test_order_sorts_the_codes(points: list[tuple[int, int, int]]) -> None:
    order = morton.order(morton.interleave(np.array(points, np.uint32)))
    assert [code_of(points[i]) for i in order] == sorted(map(code_of, points))


@given(grids)
def test_accumulate_undoes_differences(points: list[tuple[int, int, int]]) -> None:
    limbs = morton.interleave(np.array(points, np.uint32))
    limbs = limbs[morton.order(limbs)]
    steps = morton.differences(limbs)
    assert (steps < 1 << 24).all()
    np.testing.assert_array_equal(morton.accumulate(steps), limbs)
