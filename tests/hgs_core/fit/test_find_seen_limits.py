from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from hgs_core.codec.encoder.find_captured_space import find_captured_space
from hgs_core.codec.format.captured_space import CapturedSpace, Place
from hgs_core.fit.find_seen_limits import limits_where, view_from, with_seen_limits
from hgs_core.scene import DynamicSplats, HybridScene, Segment
from hgs_core.scene.camera import Camera, looking_at
from tests.hgs_core.fit.test_seen_share import scene_of, wall

ARC = CapturedSpace((0.0, 0.0, -1.0), 0.7, (-0.2, 0.4), (1.0, 3.0))
DOME = CapturedSpace((0.0, 0.0, -1.0), None, (-0.2, 0.4), (1.0, 3.0))
UP, CENTER = (0.0, -1.0, 0.0), (0.0, 0.0, 0.0)


def test_where_all_is_seen_the_limits_are_the_box() -> None:
    seen = limits_where(lambda place: 1.0, 0.95, ARC, [])
    assert set(seen.elevations) == {ARC.elevation}
    assert {pair for column in seen.distances for pair in column} == {ARC.distance}


def test_limits_lie_where_the_share_falls_below_what_is_required() -> None:
    """A share that falls evenly on the way up and on the way out: by 0.1 per radian, by 0.05 per unit."""

    def share(place: Place) -> float:
        return 1 - 0.1 * max(place.elevation, 0) - 0.05 * (place.distance - 1)

    seen = limits_where(share, 0.97, DOME, [])
    assert [low for low, _ in seen.elevations] == [-0.2] * len(seen.elevations)
    assert [high for _, high in seen.elevations] == pytest.approx([0.3] * len(seen.elevations), abs=1e-3)
    # The rows are -0.2, -0.05, 0.1, 0.25 and 0.4; in the last there is nothing, so it is the best place alone.
    expected = [[1, 1.6], [1, 1.6], [1, 1.4], [1, 1.1], [1, 1]]
    for column in seen.distances:
        np.testing.assert_allclose(column, expected, atol=1e-3)


def test_an_azimuth_where_nothing_is_seen_is_its_best_place_alone() -> None:
    seen = limits_where(lambda place: 0.5 - abs(place.elevation - 0.1) - abs(place.distance - 3), 0.95, ARC, [])
    np.testing.assert_allclose(seen.elevations, 0.1, atol=2e-4)
    np.testing.assert_allclose(seen.distances, 3.0, atol=2e-3)


def test_an_arc_ends_where_nothing_more_is_seen_and_a_dome_has_no_end() -> None:
    """A share that falls by 0.1 per radian on one side alone."""

    def share(place: Place) -> float:
        return 1 - 0.1 * max(place.azimuth, 0)

    seen = limits_where(share, 0.97, ARC, [])
    assert seen.azimuth == pytest.approx((-0.7, 0.3), abs=1e-3)
    assert limits_where(share, 0.97, DOME, []).azimuth is None


def test_a_hole_divides_the_limits_and_they_are_on_the_side_of_the_best() -> None:
    """A person stands at the height 0.1, and no camera passes through people."""
    seen = limits_where(
        lambda place: 0.0 if abs(place.elevation - 0.1) < 0.01 else 1 - place.elevation / 10, 0.95, ARC, []
    )
    assert all(low == -0.2 and high < 0.1 for low, high in seen.elevations)


places = st.builds(Place, st.floats(-0.7, 0.7), st.floats(-0.2, 0.4), st.floats(1.0, 3.0))


@settings(max_examples=30)
@example([Place(0.453125, 0.0004, 1.0)], ARC)
@given(st.lists(places, max_size=5), st.sampled_from([ARC, DOME]))
@example([Place(-0.6003688207600577, 0.0, 1.01)], ARC)
def test_the_cameras_own_places_are_inside(own: list[Place], box: CapturedSpace) -> None:
    space = CapturedSpace(
        box.front, box.azimuth, box.elevation, box.distance, limits_where(lambda _: 0.0, 0.95, box, own)
    )
    assert all(space.holds(place) for place in own)


@given(st.lists(places, max_size=3), st.floats(0.1, 7.0))
def test_limits_stay_in_the_box_and_have_few_digits(own: list[Place], slope: float) -> None:
    seen = limits_where(lambda place: math.sin(slope * (place.azimuth + place.distance)), 0.5, ARC, own)
    assert all(-0.2 <= low <= high <= 0.4 for low, high in seen.elevations)
    assert all(1 <= low <= high <= 3 for column in seen.distances for low, high in column)
    numbers = [number for pair in seen.elevations for number in pair]
    assert max(len(repr(number)) for number in numbers) <= len("-0.1234")


@given(places)
def test_a_view_stands_at_its_place_upright_with_the_centre_in_its_middle(place: Place) -> None:
    center = (1.0, 2.0, 3.0)
    eye = view_from(ARC, place, center, UP, filming(0.0))
    found = ARC.place(eye.position, center, UP)
    assert vars(found) == pytest.approx(vars(place), abs=1e-9)
    pixels, depth = eye.project(np.array([center, np.add(center, np.multiply(UP, 0.1))]))
    assert depth[0] == pytest.approx(place.distance)
    np.testing.assert_allclose(pixels[0], (32, 24), atol=1e-9)
    assert pixels[1, 0] == pytest.approx(32)
    assert pixels[1, 1] < 24


def filming(angle: float, distance: float = 2.0) -> Camera:
    place = distance * np.array([math.sin(angle), 0.0, -math.cos(angle)])
    return Camera("", 64, 48, 32.0, 32.0, 32.0, 24.0, looking_at(place, CENTER), near=0.05)


RIG = [filming(angle) for angle in np.linspace(-0.2, 0.2, 7)]


def test_before_a_wall_the_eye_stays_where_its_picture_is_within_those_of_the_cameras() -> None:
    space = find_captured_space(RIG, CENTER, UP)
    assert space is not None
    narrowed = with_seen_limits(space, CENTER, UP, scene=scene_of(wall(8, 6)), cameras=RIG)
    nearest, farthest = narrowed.distances(0.0, 0.0)
    assert nearest < 1.2
    assert 2.0 <= farthest < 2.3  # farther away its rims would show more of the wall than the cameras
    assert all(narrowed.holds(narrowed.place(camera.position, CENTER, UP)) for camera in RIG)


def test_around_a_subject_in_the_dark_there_are_no_such_limits() -> None:
    space = find_captured_space(RIG, CENTER, UP)
    assert space is not None
    assert with_seen_limits(space, CENTER, UP, scene=scene_of(wall(0.5, 0.5)), cameras=RIG) == space


@pytest.mark.parametrize(("depth", "width"), [(0.1, 0.6), (4.0, 10.0)])
def test_a_sparse_rig_has_no_limits_and_starts_without_a_room_of_single_views(depth: float, width: float) -> None:
    rig = [filming(angle) for angle in np.radians([-60, 0, 60])]
    space = find_captured_space(rig, CENTER, UP)
    assert space is not None
    found = with_seen_limits(space, CENTER, UP, scene=scene_of(wall(width, width / 3, depth)), cameras=rig)
    # As seen from a wall close behind the subject the cameras are 60 degrees apart, from one far behind it about 20.
    assert found == dataclasses.replace(space, subject_only=depth < 1)


def test_a_scene_without_splats_has_no_such_limits() -> None:
    space = find_captured_space(RIG, CENTER, UP)
    assert space is not None
    empty = HybridScene(scene_of(wall(0, 0)).static, (Segment(0.0, 1.0, DynamicSplats.empty()),))
    assert with_seen_limits(space, CENTER, UP, scene=empty, cameras=RIG) == space
