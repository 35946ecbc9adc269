from __future__ import annotations

import numpy as np
import pytest

from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats
from hgs_core.scene.splats import joined


def numbered(count: int, coefficients: int | None = None) -> StaticSplats[np.ndarray] | DynamicSplats[np.ndarray]:
    """Splats of which every number is its row's."""
    empty = StaticSplats.empty() if coefficients is None else DynamicSplats.empty(coefficients)
    values = np.arange(count, dtype=np.float32)
    return type(empty)(*(np.broadcast_to(values, (*a.shape[:0:-1], count)).T.copy() for _, a in empty.items()))


def rows(splats: StaticSplats[np.ndarray] | DynamicSplats[np.ndarray]) -> list[list[float]]:
    """The rows that each array's splats come from."""
    return [array.reshape(len(array), -1)[:, 0].tolist() for _, array in splats.items()]


def test_a_static_splat_has_14_floats_and_a_dynamic_one_29_or_35() -> None:
    sizes = [sum(array.size for _, array in numbered(1, k).items()) for k in (None, 4, 6)]
    assert sizes == [14, 29, 35]


@pytest.mark.parametrize("coefficients", [None, 4])
def test_taken_rows_are_taken_of_every_array(coefficients: int | None) -> None:
    splats = numbered(5, coefficients)
    for index, expected in (([3, 0], [3, 0]), (slice(1, 3), [1, 2]), (np.arange(5) == 4, [4])):
        found = splats.take(index)
        assert type(found) is type(splats)
        assert len(found) == len(expected)
        assert rows(found) == [expected] * len(list(splats.items()))


def test_a_conversion_meets_every_array_of_a_scene_and_leaves_the_rest() -> None:
    scene = HybridScene(numbered(2), (Segment(1.0, 3.0, numbered(3, 4)),), (0.1, 0.2, 0.3), antialiased=True)
    found = scene.map(lambda array: array + 10)
    assert rows(found.static) == [[10, 11]] * 5
    assert rows(found.segments[0].dynamic) == [[10, 11, 12]] * 7
    assert (found.start, found.end, found.background, found.antialiased) == (1.0, 3.0, (0.1, 0.2, 0.3), True)


def test_a_segments_time_runs_from_0_to_1() -> None:
    segment = Segment(2.0, 6.0, DynamicSplats.empty())
    assert [segment.normalised(seconds) for seconds in (2.0, 3.0, 6.0, 8.0)] == [0.0, 0.25, 1.0, 1.5]


def test_a_segment_of_no_length_stands_at_0() -> None:
    assert Segment(2.0, 2.0, DynamicSplats.empty()).normalised(5.0) == 0.0


def test_the_segment_shown_is_the_last_that_has_started() -> None:
    segments = tuple(Segment(start, start + 0.9, numbered(n, 4)) for n, start in enumerate((1.0, 2.0, 3.0)))
    scene = HybridScene(StaticSplats.empty(), segments)
    assert [scene.segment_at(seconds).start for seconds in (0.0, 1.0, 1.95, 2.0, 9.0)] == [1.0, 1.0, 1.0, 2.0, 3.0]
    assert (scene.start, scene.end, scene.dynamic_splats) == (1.0, 3.9, 0 + 1 + 2)


def test_joined_sets_follow_each_other() -> None:
    assert rows(joined([numbered(2), numbered(0), numbered(3)])) == [[0, 1, 0, 1, 2]] * 5


def test_joined_motions_of_fewer_coefficients_have_higher_ones_of_zero() -> None:
    short, long = numbered(2, 4), numbered(3, 6)
    found = joined([short, long])
    assert found.motion.shape == (5, 6, 3)
    assert found.motion[1, :, 0].tolist() == [1, 1, 1, 1, 0, 0]
    assert found.motion[4, :, 0].tolist() == [2] * 6
