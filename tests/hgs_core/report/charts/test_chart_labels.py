from __future__ import annotations

import itertools

import numpy as np
import pytest

from hgs_core.report.charts.chart_labels import around_points, overlap, spread


@pytest.mark.parametrize("seed", range(5))
def test_labels_beside_lines_keep_apart_inside_their_room(seed: int) -> None:
    places = np.random.default_rng(seed).uniform(0, 100, 8).tolist()
    moved = spread(places, 14, 0, 100)
    assert all(b - a >= 14 - 1e-9 for a, b in itertools.pairwise(sorted(moved)))
    assert min(moved) >= -1e-9
    assert max(moved) <= 100 + 1e-9
    assert np.argsort(moved).tolist() == np.argsort(places).tolist()


def test_labels_that_keep_apart_already_stay_where_they_are() -> None:
    assert spread([50, 10, 80], 14, 0, 100) == [50, 10, 80]


@pytest.mark.parametrize("seed", range(5))
def test_labels_of_points_cover_neither_each_other_nor_points(seed: int) -> None:
    r = np.random.default_rng(seed)
    points = [(float(x), float(y)) for x, y in r.uniform((60, 40), (380, 240), (12, 2))]
    frame = (40.0, 20.0, 400.0, 260.0)
    boxes = [box for box in around_points(points, [f"run number {i}" for i in range(12)], frame) if box]
    assert len(boxes) >= 10
    assert not any(overlap(a, b) for a, b in itertools.combinations(boxes, 2))
    for x0, y0, x1, y1 in boxes:
        assert not any(x0 < x < x1 and y0 < y < y1 for x, y in points)
        assert frame[0] <= x0 < x1 <= frame[2]
        assert frame[1] <= y0 < y1 <= frame[3]


def test_a_label_without_a_free_place_is_left_out() -> None:
    assert around_points([(5.0, 5.0)], ["a name wider than the frame"], (0, 0, 20, 20)) == [None]
