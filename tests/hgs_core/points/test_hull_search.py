"""First points of a body that walks among three cameras far apart."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hgs_core.base.progress import silent
from hgs_core.capture.open import open_capture
from hgs_core.decompose.masks import motion_masks
from hgs_core.points.backdrop import load_backdrop
from hgs_core.points.hull_search import HullSearch
from hgs_core.points.kept_points import BACKDROP, keep_points, segment_points
from tests.walking_body import CAMERAS, body, write_walk

FRAMES = 6
VIEWS = (0, 1, 2)


@pytest.fixture(scope="module")
def search(tmp_path_factory: pytest.TempPathFactory) -> HullSearch:
    folder = tmp_path_factory.mktemp("walk")
    write_walk(folder, FRAMES)
    return search_in(folder)


@pytest.fixture(scope="module")
def informed(tmp_path_factory: pytest.TempPathFactory) -> HullSearch:
    """A search with depths of the first camera: a wall 5 m away on the left, and its movers 2.75 m away at frame 3."""
    folder = tmp_path_factory.mktemp("known walk")
    write_walk(folder, FRAMES)
    (folder / "depth" / "0").mkdir(parents=True)
    (folder / "depth" / "depth.json").write_text(json.dumps({"scale": 0.001}))
    for frame in range(FRAMES):
        depths = np.zeros((240, 320), np.uint16)
        depths[:, :160] = 5000
        moving = np.array(Image.open(folder / "seg" / "0" / f"{frame:06d}.png")) > 0
        depths[moving] = 2750 if frame == 3 else 0
        Image.fromarray(depths).save(folder / "depth" / "0" / f"{frame:06d}.png")
    return search_in(folder)


def search_in(folder: Path) -> HullSearch:
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


def test_still_points_lie_at_given_depths_and_the_others_on_the_backdrop(informed: HullSearch) -> None:
    still = informed.still(informed.features(0), [], np.random.default_rng(0))
    places, _ = informed.backdrop.nearest(still.xyz.astype(np.float64))
    given = np.linalg.norm(still.xyz - places, axis=1) > 1e-3
    assert 0.1 < given.mean() < 0.3
    pixels, depths = CAMERAS[0].project(still.xyz[given])
    np.testing.assert_allclose(depths, 5.0, rtol=1e-5)
    assert (pixels[:, 0] < 160).all()
    towards = np.abs(still.normal[given] @ CAMERAS[0].world_to_camera[2, :3])
    assert np.median(towards) == pytest.approx(1.0, abs=1e-3)


def test_a_mesh_before_a_camera_hides_nothing(tmp_path: Path) -> None:
    write_walk(tmp_path, FRAMES)
    camera = CAMERAS[0]
    corners = camera.position + camera.rays(np.array([[-99.0, -99], [999, -99], [999, 999], [-99, 999]])) * 0.05
    lines = [f"v {x} {y} {z}\n" for x, y, z in corners]
    (tmp_path / "mesh.obj").write_text("".join(lines) + "f 1 2 3 4\n")
    given = search_in(tmp_path).backdrop.given
    assert given is not None
    assert not given.maps["0"].any()


def test_moving_points_lie_at_depths_of_their_frame(informed: HullSearch) -> None:
    _, known = CAMERAS[0].project(informed.moving(3, 200, [], np.random.default_rng(0)).xyz)
    _, unknown = CAMERAS[0].project(informed.moving(4, 200, [], np.random.default_rng(0)).xyz)
    assert np.isclose(known, 2.75, atol=1e-4).mean() > 0.1
    assert not np.isclose(unknown, 2.75, atol=1e-4).any()


def test_given_depths_are_kept_with_the_backdrop(informed: HullSearch, tmp_path: Path) -> None:
    keep_points(tmp_path, informed, [(0,)], seed=0, progress=silent)
    found = load_backdrop(tmp_path / BACKDROP)
    assert found is not None
    assert found.given is not None
    assert informed.backdrop.given is not None
    assert list(found.given.maps) == ["0"]
    np.testing.assert_array_equal(found.given.maps["0"], informed.backdrop.given.maps["0"])


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
