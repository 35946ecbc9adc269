"""The first points, from half of the sample's cameras, judged by a camera that was not used."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.base.progress import silent
from hgs_core.capture.capture import Capture
from hgs_core.capture.open import open_capture
from hgs_core.decompose.masks import MotionMasks, motion_masks
from hgs_core.native import library
from hgs_core.points.initial_points import PointSearch
from hgs_core.points.point_cloud import PointCloud

VIEWS = (1, 3, 5, 7, 9, 11)
MOMENTS = (0, 30)
TARGETS: dict[str, Any] = {"static_target": 2500, "dynamic_target": 600, "normals": True}


class OnlyViews(Capture):
    """The sample, which refuses to show other cameras."""

    def frame(self, camera: int, frame: int) -> Any:
        assert camera in VIEWS
        return super().frame(camera, frame)


@pytest.fixture(scope="module")
def capture() -> Capture:
    opened = open_capture(Path(__file__).resolve().parents[3] / "samples" / "studio")
    opened.__class__ = OnlyViews
    return opened


@pytest.fixture(scope="module")
def masks(capture: Capture) -> MotionMasks:
    return motion_masks(capture, VIEWS, progress=silent)


def found(capture: Capture, masks: MotionMasks, moments: tuple[int, ...] = MOMENTS, **targets: Any) -> PointCloud:
    search = PointSearch(capture, VIEWS, masks, **(TARGETS | targets))
    generator = np.random.default_rng(0)
    features = search.features(moments[0])
    ranges = search.ranges(features)
    parts = [search.still(features, ranges, generator)]
    count = search.dynamic_target // len(moments)
    parts += [
        search.moving(frame, count, ranges, generator, features if frame == moments[0] else None) for frame in moments
    ]
    return PointCloud.concatenate(parts)


@pytest.fixture(scope="module")
def points(capture: Capture, masks: MotionMasks) -> PointCloud:
    return found(capture, masks)


def test_the_targets_are_met(points: PointCloud) -> None:
    static = int((points.dynamic < 0.5).sum())
    assert 2200 <= static <= 2500
    assert 400 <= len(points) - static <= 600


def test_dynamic_points_come_from_every_moment(points: PointCloud) -> None:
    times = points.times[points.dynamic >= 0.5]
    np.testing.assert_allclose(np.unique(times), [0, 1], atol=1e-6)
    assert min((times == time).sum() for time in np.unique(times)) > 150
    np.testing.assert_array_equal(points.times[points.dynamic < 0.5], 0)


def test_spacing_is_positive_and_of_the_size_of_the_gaps(points: PointCloud) -> None:
    assert points.spacing.min() > 0
    assert 0.01 < np.median(points.spacing) < 0.2
    assert points.spacing.max() < 1.0


def test_what_stands_still_knows_the_surfaces_it_lies_on(points: PointCloud) -> None:
    still = points.dynamic < 0.5
    known = points.normal.any(axis=1)
    assert 0.5 < known[still].mean() < 1
    assert not known[~still].any()
    np.testing.assert_allclose(np.linalg.norm(points.normal[known], axis=1), 1, atol=1e-5)


def test_a_coarse_sweep_and_no_surfaces_can_be_asked_for(capture: Capture, masks: MotionMasks) -> None:
    asked: dict[str, Any] = {"static_target": 9_000, "dynamic_target": 50, "normals": False, "stereo": False}
    points = found(capture, masks, (0,), **asked)
    assert 1_000 < (points.dynamic < 0.5).sum() <= 6_500
    assert not points.normal.any()


def test_an_unused_camera_confirms_places_and_colours(points: PointCloud) -> None:
    """Most points, seen from cam00, have the colour of its picture there; occluded ones need not."""
    capture = open_capture(Path(__file__).resolve().parents[3] / "samples" / "studio")
    for moment, frame in ((0.0, 0), (1.0, 30)):
        shown = points.take((points.dynamic < 0.5) | (points.times == np.float32(moment)))
        pixels, depth = capture.cameras[0].project(shown.xyz)
        column, row = pixels.astype(int).T
        inside = (depth > 0) & (column >= 0) & (column < 512) & (row >= 0) & (row < 384)
        picture = capture.frame(0, frame)[row[inside], column[inside]] / 255
        difference = np.abs(picture - shown.rgb[inside]).mean(axis=1)
        assert inside.mean() > 0.6
        assert np.median(difference) < 0.08


def test_moving_points_project_into_the_masks(points: PointCloud, capture: Capture, masks: MotionMasks) -> None:
    moving = points.take((points.dynamic >= 0.5) & (points.times == 0))
    inside = []
    for view in VIEWS:
        column, row = capture.cameras[view].project(moving.xyz)[0].astype(int).T
        seen = (column >= 0) & (column < 512) & (row >= 0) & (row < 384)
        inside.append(masks.mask(view, 0)[row[seen], column[seen]].mean())
    assert np.mean(inside) > 0.8


def test_one_camera_is_too_few(capture: Capture, masks: MotionMasks) -> None:
    with pytest.raises(InputError, match="1 camera to start from"):
        PointSearch(capture, VIEWS[:1], masks, **TARGETS)


def test_the_same_seed_gives_the_same_bits(points: PointCloud, capture: Capture, masks: MotionMasks) -> None:
    again = found(capture, masks)
    for name in ("xyz", "rgb", "times", "dynamic", "spacing"):
        assert getattr(again, name).tobytes() == getattr(points, name).tobytes()


class HalfLate(OnlyViews):
    """Every other of the cameras took its frames half a period late, it says."""

    def moment(self, camera: int, frame: int) -> float:
        return super().moment(camera, frame) + (0.5 / 30 if camera in VIEWS[1::2] else 0.0)


def test_what_moves_is_taken_from_cameras_that_are_in_step_at_their_own_time(
    capture: Capture, masks: MotionMasks, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(capture, "__class__", HalfLate)
    points = found(capture, masks, static_target=100)
    times = np.unique(points.times[points.dynamic >= 0.5])
    np.testing.assert_allclose(times, [0.0, 0.5 / 30, 1.0, 1.0 + 0.5 / 30], atol=1e-6)


def test_without_kernels_a_coarse_sweep_has_to_do(
    capture: Capture, masks: MotionMasks, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HGS_NATIVE_ISA", "none")
    library._loaded.cache_clear()
    try:
        points = found(capture, masks, static_target=9_000)
    finally:
        monkeypatch.undo()
        library._loaded.cache_clear()
    assert 1_000 < (points.dynamic < 0.5).sum() <= 6_500


def test_given_depth_gives_points_where_the_pictures_agree_with_it_or_see_less(
    capture: Capture, masks: MotionMasks, tmp_path: Path
) -> None:
    """A wall behind all others, known to one camera: no other sees through it."""
    camera = capture.cameras[VIEWS[2]]
    Image.fromarray(np.full((camera.height, camera.width), 7000, np.uint16)).save(tmp_path / f"{camera.name}.png")
    (tmp_path / "depth.json").write_text('{"scale": 0.001}')
    given = open_capture(capture.path, depth=tmp_path)
    given.__class__ = OnlyViews
    points = found(given, masks)
    still = points.xyz[points.dynamic < 0.5]
    _, depths = camera.project(still)
    assert np.isclose(depths, 7.0, rtol=1e-5).sum() > 100
    assert len(still) <= TARGETS["static_target"]


def test_a_mesh_right_before_a_camera_changes_nothing(
    capture: Capture, masks: MotionMasks, points: PointCloud, tmp_path: Path
) -> None:
    """A scan of the room closes the hole through which the camera looks."""
    camera = capture.cameras[VIEWS[2]]
    corners = camera.position + 0.02 * camera.rays(np.array([[-9.0, -9], [999, -9], [999, 999], [-9, 999]]))
    lines = [f"v {x} {y} {z}\n" for x, y, z in corners]
    (tmp_path / "mesh.obj").write_text("".join(lines) + "f 1 2 3 4\n")
    given = open_capture(capture.path, mesh=tmp_path / "mesh.obj")
    given.__class__ = OnlyViews
    search = PointSearch(given, VIEWS, masks, **TARGETS)
    features = search.features(MOMENTS[0])
    still = search.still(features, search.ranges(features), np.random.default_rng(0))
    np.testing.assert_array_equal(still.xyz, points.xyz[: len(still)])
