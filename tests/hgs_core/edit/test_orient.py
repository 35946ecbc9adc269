"""A turned scene from turned cameras looks as it did, drawn by the reference in float64."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hgs_core.base.errors import InputError
from hgs_core.edit.orient import UPWARDS, Similarity, orient, turn_about, turn_up
from hgs_core.scene.rotations import matrices
from tests.hgs_core.edit.scenes import CAMERAS, moving, picture, still, with_static
from tests.tolerances import TOLERANCES

RTOL, ATOL = TOLERANCES["float32"]
number = st.floats(-3, 3)


@settings(max_examples=8, deadline=None)
@given(
    st.tuples(number, number, number).filter(lambda axis: np.linalg.norm(axis) > 0.1),
    st.floats(-180, 180),
    st.floats(0.1, 10),
    st.tuples(number, number, number),
)
def test_an_oriented_scene_is_the_same_from_its_moved_cameras(
    axis: tuple[float, ...], degrees: float, scale: float, shift: tuple[float, ...]
) -> None:
    viewed = moving(2, antialiased=True)
    edited = orient(viewed, Similarity(turn_about([*axis, degrees]), scale, np.array(shift))).viewed
    for camera, moved, seconds in zip(CAMERAS, edited.cameras, (2.4, 3.65, 5.0), strict=True):
        before, after = picture(viewed, camera, seconds), picture(edited, moved, seconds)
        np.testing.assert_allclose(after, before, RTOL, ATOL * 50)  # places are rounded to float32 in the moved world


def test_a_quaternion_of_no_length_turns_as_the_identity_that_it_stands_for() -> None:
    viewed = with_static(moving(), quats=np.zeros((120, 4), np.float32))
    viewed.scene.segments[0].dynamic.rotation[:5] = 0
    edited = orient(viewed, Similarity(turn_about([1, 2, 3, 77]), 1.0, np.zeros(3))).viewed
    before, after = picture(viewed, CAMERAS[0], 2.5), picture(edited, edited.cameras[0], 2.5)
    np.testing.assert_allclose(after, before, RTOL, ATOL * 50)


def test_a_positive_angle_turns_counter_clockwise_seen_from_the_axis_tip() -> None:
    np.testing.assert_allclose(matrices(turn_about([0, 0, 2, 90])) @ [1, 0, 0], [0, 1, 0], atol=1e-12)


@pytest.mark.parametrize("up", [[0, 0, 1], [0, 5, 0], [0, -1, 0], [1, 2, -3]])
def test_up_becomes_the_direction_that_is_upwards(up: list[float]) -> None:
    turn = turn_up([float(x) for x in up])
    np.testing.assert_allclose(matrices(turn) @ up / np.linalg.norm(up), UPWARDS, atol=1e-12)
    viewed = dataclasses.replace(still(), up=(1.0, 0.0, 0.0))
    assert orient(viewed, Similarity(turn, 1.0, np.zeros(3)), up=True).viewed.up == UPWARDS


def test_without_a_new_up_the_old_one_turns_along() -> None:
    turned = orient(still(), Similarity(turn_about([0, 0, 1, 90]), 2.0, np.ones(3))).viewed
    np.testing.assert_allclose(turned.up, [1, 0, 0], atol=1e-12)  # -y before


def test_one_change_after_another_is_their_product() -> None:
    a = Similarity(turn_about([1, 0, 0, 30]), 2.0, np.array([1.0, 2.0, 3.0]))
    b = Similarity(turn_about([0, 1, 1, 50]), 0.5, np.array([-1.0, 0.0, 4.0]))
    twice = orient(orient(still(), a).viewed, b).viewed.scene.static.means
    np.testing.assert_allclose(orient(still(), a.then(b)).viewed.scene.static.means, twice, atol=1e-5)


def test_what_turns_or_scales_nothing_is_refused() -> None:
    with pytest.raises(InputError, match=r"--scale: 0\.0 is not positive"):
        orient(still(), Similarity(turn_about([1, 0, 0, 0]), 0.0, np.zeros(3)))
    with pytest.raises(InputError, match="--rotate: is no axis and angle"):
        turn_about([0, 0, 0, 90])
    with pytest.raises(InputError, match="--up: is no direction"):
        turn_up([0, 0, 0])


@pytest.mark.parametrize(
    "change",
    [
        Similarity(np.array([1.0, 0, 0, 0]), 1e300, np.zeros(3)),
        Similarity(np.array([1.0, 0, 0, 0]), 1e-300, np.zeros(3)),
        Similarity(np.array([1.0, 0, 0, 0]), 1.0, np.array([0, 1e39, 0])),
        Similarity(np.array([1.0, 0, 0, 0]), 1.0, np.array([0, 1e9, 0])),
    ],
)
def test_places_that_numbers_cannot_hold_are_refused(change: Similarity) -> None:
    with pytest.raises(InputError, match="beyond 32-bit numbers; scale nearer to 1, move by less"):
        orient(moving(), change)
