from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hgs_core.codec import load_manifest
from hgs_core.codec.encoder.find_captured_space import find_captured_space
from hgs_core.codec.format.captured_space import CapturedSpace
from hgs_core.codec.format.seen_limits import SeenLimits
from hgs_core.scene import DynamicSplats, HybridScene, Segment
from hgs_core.scene.camera import Camera, looking_at
from tests.hgs_core.codec.scenes import encode, scene

UP = (0.0, -1.0, 0.0)
CENTER = (1.0, 2.0, 3.0)
DEGREES = math.pi / 180


def camera(azimuth: float, elevation: float = 0.0, distance: float = 4.0, *, outward: bool = False) -> Camera:
    """A camera in degrees around `CENTER` that looks at it: azimuth 0 looks along z, 90 stands to the right of that."""
    a, e = azimuth * DEGREES, elevation * DEGREES
    offset = distance * np.array([math.cos(e) * math.sin(a), -math.sin(e), -math.cos(e) * math.cos(a)])
    place = offset + CENTER
    pose = looking_at(place, place + offset if outward else CENTER)
    return Camera(f"{azimuth} {elevation}", 640, 360, 500.0, 500.0, 320.0, 180.0, pose)


def test_an_arc_is_its_angles_and_the_typical_step_beyond_them() -> None:
    cameras = [camera(azimuth, elevation) for azimuth in range(100, 161, 10) for elevation in (0, 20)]
    space = find_captured_space(cameras, CENTER, UP)
    assert space is not None
    across = 130 * DEGREES
    np.testing.assert_allclose(space.front, [math.sin(across), 0, -math.cos(across)], atol=1e-9)
    # The cameras of the upper row are nearer to each other: 10 degrees times the cosine of their elevation, about.
    upper = 2 * math.asin(math.cos(20 * DEGREES) * math.sin(5 * DEGREES))
    margin = (upper + 10 * DEGREES) / 2
    assert space.azimuth == pytest.approx(30 * DEGREES + margin)
    assert space.elevation == pytest.approx((-margin, 20 * DEGREES + margin))
    assert space.distance == pytest.approx((2.0, 5.0))


def test_an_arc_across_the_seam_of_the_angles_is_one_arc() -> None:
    space = find_captured_space([camera(azimuth) for azimuth in (160, 170, 180, -170, -160)], CENTER, UP)
    assert space is not None
    assert space.azimuth == pytest.approx(30 * DEGREES)
    np.testing.assert_allclose(space.front, [0, 0, 1], atol=1e-9)


@pytest.mark.parametrize("count", [4, 8, 30])
def test_cameras_all_round_leave_the_azimuth_open(count: int) -> None:
    cameras = [camera(360 * i / count + 0.1 * (i % 2), 10) for i in range(count)]
    space = find_captured_space(cameras, CENTER, UP, moves=False)
    assert space is not None
    # Four cameras leave a gap a tenth of a degree too wide.
    assert (space.azimuth is None) == (count > 4)


def test_a_camera_straight_above_widens_the_elevation_alone() -> None:
    arc = [camera(azimuth, 5) for azimuth in (-20, -10, 0, 10, 20)]
    without, with_it = (find_captured_space(cameras, CENTER, UP) for cameras in (arc, [*arc, camera(170, 80)]))
    assert without is not None
    assert with_it is not None
    assert with_it.azimuth == pytest.approx(without.azimuth, rel=0.01)
    assert with_it.elevation[1] == pytest.approx(min(90, 80 + 10) * DEGREES, abs=0.1 * DEGREES)


@pytest.mark.parametrize(("step", "margin"), [(1, 5), (8, 8), (40, 15)])
def test_the_margin_follows_the_step_between_cameras_within_limits(step: float, margin: float) -> None:
    space = find_captured_space([camera(step * i) for i in range(4)], CENTER, UP)
    assert space is not None
    assert space.azimuth == pytest.approx((1.5 * step + margin) * DEGREES)
    assert space.elevation == pytest.approx((-margin * DEGREES, margin * DEGREES))


@pytest.mark.parametrize("count", [3, 4, 6])
def test_few_cameras_around_have_a_cone_each_and_leave_the_azimuth_open(count: int) -> None:
    azimuths = [360 * i / count for i in range(count)]
    space = find_captured_space([camera(azimuth) for azimuth in azimuths], CENTER, UP)
    assert space is not None
    assert space.azimuth is None
    expected = [(math.sin(a * DEGREES), 0, -math.cos(a * DEGREES)) for a in azimuths]
    np.testing.assert_allclose(space.cones, expected, atol=1e-9)


def test_few_cameras_on_one_side_have_a_cone_each_and_an_end() -> None:
    space = find_captured_space([camera(azimuth) for azimuth in (-60, 0, 60)], CENTER, UP)
    assert space is not None
    assert len(space.cones) == 3
    assert space.azimuth == pytest.approx(75 * DEGREES)


@pytest.mark.parametrize("step", [10, 39])
def test_cameras_near_each_other_have_no_cones(step: float) -> None:
    space = find_captured_space([camera(step * i) for i in range(4)], CENTER, UP)
    assert space is not None
    assert space.cones == ()


def test_where_nothing_moves_there_are_no_cones() -> None:
    space = find_captured_space([camera(azimuth) for azimuth in (0, 120, 240)], CENTER, UP, moves=False)
    assert space is not None
    assert space.cones == ()
    assert space.azimuth is not None


def test_one_camera_has_a_space_around_it() -> None:
    space = find_captured_space([camera(40, 10)], CENTER, UP)
    assert space is not None
    assert space.azimuth == pytest.approx(5 * DEGREES)


def test_cameras_that_look_around_from_the_middle_have_no_such_space() -> None:
    around = [camera(azimuth, distance=0.1, outward=True) for azimuth in range(0, 360, 30)]
    assert find_captured_space(around, CENTER, UP) is None
    assert find_captured_space([], CENTER, UP) is None


places = st.tuples(st.floats(-180, 180), st.floats(-74, 74), st.floats(0.5, 10))


@given(st.lists(places, min_size=1, max_size=12))
def test_every_camera_is_inside(found: list[tuple[float, float, float]]) -> None:
    cameras = [camera(*place) for place in found]
    space = find_captured_space(cameras, CENTER, UP)
    assert space is not None
    assert all(space.holds(space.place(one.position, CENTER, UP)) for one in cameras)
    assert np.dot(space.front, UP) == pytest.approx(0, abs=1e-9)
    assert np.linalg.norm(space.front) == pytest.approx(1)


def test_the_manifest_tells_of_the_training_cameras_and_the_chunks_stay_as_they_were(
    tmp_path: Path, cameras: list[Camera]
) -> None:
    without = encode(scene(), tmp_path / "without", cameras)
    manifest = encode(scene(), tmp_path / "with", cameras, trained=cameras[:3])
    assert without.captured_space is None
    assert manifest.captured_space == find_captured_space(cameras[:3], manifest.center, manifest.up)
    assert load_manifest(tmp_path / "with").captured_space == manifest.captured_space
    assert manifest.chunks == without.chunks


def test_the_manifest_of_a_sparse_rig_has_its_cones_if_something_moves(tmp_path: Path) -> None:
    rig = [camera(azimuth) for azimuth in (0, 120, 240)]
    moving = encode(scene(), tmp_path / "moving", rig, trained=rig)
    still = HybridScene(scene().static, (Segment(0.0, 1.0, DynamicSplats.empty()),))
    standing = encode(still, tmp_path / "still", rig, trained=rig)
    assert moving.captured_space is not None
    assert len(moving.captured_space.cones) == 3
    assert load_manifest(tmp_path / "moving").captured_space == moving.captured_space
    assert standing.captured_space is not None
    assert standing.captured_space.cones == ()


def test_the_manifest_has_the_space_as_it_is_narrowed_and_the_chunks_stay_as_they_were(
    tmp_path: Path, cameras: list[Camera]
) -> None:
    given = []

    def narrowed(space: CapturedSpace, *where: tuple[float, float, float]) -> CapturedSpace:
        given.append((space, *where))
        return dataclasses.replace(space, seen=SeenLimits((space.elevation,) * 2, ((space.distance,) * 2,) * 2))

    whole = encode(scene(), tmp_path / "whole", cameras, trained=cameras)
    manifest = encode(scene(), tmp_path / "narrowed", cameras, trained=cameras, narrowed=narrowed)
    assert given == [(whole.captured_space, whole.center, whole.up)]
    assert manifest.captured_space is not None
    assert manifest.captured_space.seen is not None
    assert load_manifest(tmp_path / "narrowed").captured_space == manifest.captured_space
    assert manifest.chunks == whole.chunks
    assert encode(scene(), tmp_path / "unknown", cameras, narrowed=narrowed).captured_space is None


@pytest.mark.parametrize("alone", [False, True])
def test_the_thumbnail_is_that_of_the_space_as_it_is_narrowed(
    tmp_path: Path, cameras: list[Camera], alone: bool
) -> None:
    def narrowed(space: CapturedSpace, *where: tuple[float, float, float]) -> CapturedSpace:
        return dataclasses.replace(space, subject_only=alone)

    encode(scene(), tmp_path, cameras, trained=cameras, narrowed=narrowed, thumbnail=lambda asked: str(asked).encode())
    assert (tmp_path / "thumbnail.jpg").read_bytes() == str(alone).encode()
