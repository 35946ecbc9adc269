"""First points of a body that walks among three cameras far apart."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.progress import silent
from hgs_core.capture.open import open_capture
from hgs_core.decompose.masks import motion_masks
from hgs_core.points.backdrop import load_backdrop
from hgs_core.points.hull_search import HullSearch
from hgs_core.points.kept_points import BACKDROP, keep_points, segment_points
from tests.walking_body import body, write_walk

FRAMES = 6
VIEWS = (0, 1, 2)


@pytest.fixture(scope="module")
def search(tmp_path_factory: pytest.TempPathFactory) -> HullSearch:
    folder = tmp_path_factory.mktemp("walk")
    write_walk(folder, FRAMES)
    capture = open_capture(folder)
    masks = motion_masks(capture, VIEWS, progress=silent)
    return HullSearch(capture, VIEWS, masks, static_target=600, dynamic_target=400)


def test_still_points_lie_on_the_backdrop_with_the_colours_of_the_room(search: HullSearch) -> None:
    still = search.still(search.features(0), [], np.random.default_rng(0))
    assert 500 < len(still) < 2500
    places, normals = search.backdrop.nearest(still.xyz.astype(np.float64))
    np.testing.assert_allclose(still.xyz, places, atol=1e-4)
    np.testing.assert_allclose(np.abs((still.normal * normals).sum(1)), 1.0, atol=1e-4)
    floor, wall = (np.isclose(still.rgb[:, 0], value / 255, atol=0.02) for value in (60, 200))
    assert (floor | wall).all()
    assert floor.any()
    assert wall.any()
    assert not still.dynamic.any()


def test_moving_points_lie_on_the_body_and_are_no_more_than_asked_for(search: HullSearch) -> None:
    found = search.moving(3, 200, [], np.random.default_rng(0))
    assert 100 < len(found) <= 200
    middle = body(3 / (3 * FRAMES)).mean(0)
    aside = np.linalg.norm((found.xyz - middle)[:, [0, 2]], axis=1)
    assert np.quantile(aside, 0.95) < 0.4
    assert (found.dynamic == 1).all()
    assert found.times == pytest.approx(search.capture.times[3])


def test_there_are_no_features(search: HullSearch) -> None:
    assert len(search.features(0)) == 0


def test_the_backdrop_is_kept_with_the_points(search: HullSearch, tmp_path: Path) -> None:
    keep_points(tmp_path, search, [(0, 2), (2, 5)], seed=0, progress=silent)
    assert load_backdrop(tmp_path / BACKDROP) == search.backdrop
    kept = segment_points(tmp_path, 1)
    assert (kept.dynamic == 1).any()
    assert (kept.dynamic == 0).any()


def test_the_same_seed_finds_the_same_points(search: HullSearch) -> None:
    one, two = (search.moving(2, 100, [], np.random.default_rng(5)) for _ in range(2))
    np.testing.assert_array_equal(one.xyz, two.xyz)
