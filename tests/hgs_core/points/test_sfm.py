"""Triangulation on one moment of the sample, checked through the renderer's own cameras."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from hgs_core.capture.open import open_capture
from hgs_core.points.sfm import SparsePoints, camera_pairs, triangulate
from hgs_core.scene.camera import Camera

VIEWS = (1, 2, 3, 4, 5, 6)


@pytest.fixture(scope="module")
def pictures() -> list[np.ndarray]:
    capture = open_capture(Path(__file__).resolve().parents[3] / "samples" / "studio")
    return [capture.frame(view, 0) for view in (*VIEWS, 0)]


@pytest.fixture(scope="module")
def truth() -> list[Camera]:
    meta = json.loads((Path(__file__).resolve().parents[3] / "samples" / "studio" / "cameras.json").read_text())
    cameras = [meta["cameras"][view] for view in (*VIEWS, 0)]
    return [Camera(c["name"], 512, 384, c["fx"], c["fy"], c["cx"], c["cy"], np.array(c["w2c"])) for c in cameras]


@pytest.fixture(scope="module")
def points(pictures: list[np.ndarray], truth: list[Camera]) -> SparsePoints:
    return triangulate(truth[:-1], pictures[:-1])


def test_points_reproject_below_a_pixel(points: SparsePoints) -> None:
    assert len(points.xyz) > 300
    assert np.median(points.errors) < 0.6
    assert points.seen.sum(axis=1).min() >= 3


def test_points_lie_in_the_room(points: SparsePoints) -> None:
    """The room is about 5 m wide and 3 m high, z up; a mirrored axis would put points behind the cameras."""
    inside = ((points.xyz > (-3, -1.5, -0.1)) & (points.xyz < (3, 3, 3.2))).all(axis=1)
    assert inside.mean() > 0.98


def test_a_view_that_was_not_used_sees_the_same_colours(
    points: SparsePoints, pictures: list[np.ndarray], truth: list[Camera]
) -> None:
    """Colours around the projections in cam00 agree far better than at shifted places, as pixel-exact points must."""
    pixels, _ = truth[-1].project(points.xyz)

    def difference(shift: float) -> float:
        column, row = (pixels + shift).astype(int).T
        inside = (column >= 0) & (column < 512) & (row >= 0) & (row < 384)
        return float(np.median(np.abs(pictures[-1][row[inside], column[inside]] / 255 - points.rgb[inside])))

    assert difference(0) < 0.05
    assert difference(6) > 2 * difference(0)


def test_the_same_pictures_give_the_same_bits(pictures: list[np.ndarray], truth: list[Camera]) -> None:
    masks = [np.zeros((384, 512), bool) for _ in range(4)]
    for mask in masks:
        mask[230:, 100:400] = True
    first, second = (triangulate(truth[:4], pictures[:4], masks) for _ in range(2))
    assert len(first.xyz) > 50
    assert first.xyz.tobytes() == second.xyz.tobytes()
    assert first.rgb.tobytes() == second.rgb.tobytes()


def test_pictures_without_texture_give_no_points(truth: list[Camera]) -> None:
    points = triangulate(truth[:3], [np.zeros((384, 512, 3), np.uint8)] * 3)
    assert points.xyz.shape == (0, 3)
    assert points.seen.shape == (0, 3)


@pytest.mark.parametrize(("count", "pairs"), [(3, 3), (20, 190)])
def test_every_pair_of_few_cameras_is_matched(count: int, pairs: int) -> None:
    assert len(camera_pairs(ring(count))) == pairs


def test_many_cameras_are_matched_to_their_neighbours() -> None:
    pairs = camera_pairs(ring(40))
    assert all(min(b - a, 40 - b + a) <= 4 for a, b in pairs)
    assert len(pairs) == 160


def ring(count: int) -> list[Camera]:
    cameras = []
    for angle in np.linspace(0, 2 * np.pi, count, endpoint=False):
        c, s = np.cos(angle), np.sin(angle)
        pose = np.eye(4)
        pose[:3, :3] = [[c, 0, s], [0, 1, 0], [-s, 0, c]]
        pose[2, 3] = 3.0
        cameras.append(Camera(f"{angle:.3f}", 64, 48, 50, 50, 32, 24, pose))
    return cameras
