"""Numbers that are finite and mean nothing, or more than can be drawn."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hgs_core.interchange import import_scene
from hgs_core.interchange.drawable import drawable
from hgs_core.interchange.ply.spacetime_ply import spacetime_ply
from hgs_core.interchange.splat_file import splat_file
from hgs_core.scene import DynamicSplats, StaticSplats
from hgs_core.scene.rotations import unit_quaternions
from tests.hgs_core.interchange.scenes import Write, dynamics, gaussian_ply_of, statics

NONE, UNEVEN = "by none at all: the quaternion has no length", "by one of length 1: its direction alone counts"


def reasons(path: object) -> dict[str, int | None]:
    return {change.reason: change.count for change in import_scene(path).changes}  # type: ignore[arg-type]


@pytest.mark.parametrize("turn", [0.0, 1.0])
def test_rows_of_zeros_are_left_out(written: Write, turn: float) -> None:
    """Unfilled rows would be drawn as a fog: a scale of e^0, half an opacity; perhaps with a rotation of 1, 0, 0, 0."""
    given = statics()
    for _, array in given.items():
        array[10:] = 0
    given.quats[10:, 0] = turn
    found = import_scene(written("x.ply", gaussian_ply_of(given)))
    assert (len(found.scene.static), found.splats) == (10, 50)
    assert str(found.changes[0]).startswith("40 of 50 splats left out: scale, opacity, and rotation or place")


@pytest.mark.parametrize(("value", "reason"), [(0.0, NONE), (1e-30, NONE), (7.0, UNEVEN), (1e30, UNEVEN)])
def test_rotations_without_length_are_none_and_others_become_unit_ones(
    written: Write, value: float, reason: str
) -> None:
    given = statics()
    given.quats[:7] *= np.float32(value)
    path = written("x.ply", gaussian_ply_of(given))
    assert reasons(path)[reason] == 7
    found = import_scene(path).scene.static.quats
    expected = np.tile([1.0, 0, 0, 0], (7, 1)) if reason == NONE else unit_quaternions(statics().quats[:7])
    np.testing.assert_allclose(found[:7], expected, atol=1e-6)


def test_what_moves_is_turned_as_before(written: Write) -> None:
    """The whole polynomial is scaled: a quarter of the splats have no rotation, a quarter one of length 9."""
    dynamic = dynamics(40)
    dynamic.rotation[:10] = 0
    dynamic.rotation[10:20] *= 9
    path = written("x.ply", spacetime_ply(StaticSplats.empty(), dynamic).data)
    told = reasons(path)
    assert (told[NONE], told[UNEVEN]) == (10, 10)
    found = import_scene(path).scene.segments[0].dynamic.rotation
    np.testing.assert_array_equal(found[:10], np.tile([[1.0, 0, 0, 0], [0, 0, 0, 0]], (10, 1, 1)))
    np.testing.assert_allclose(found[10:20], dynamics(40).rotation[10:20], atol=1e-6)


def test_bytes_of_a_splat_file_are_near_enough_to_a_length_of_1(written: Write) -> None:
    rows = np.frombuffer(splat_file(statics()).data, np.uint8).reshape(-1, 32).copy()
    assert UNEVEN not in reasons(written("x.splat", rows.tobytes()))
    rows[:3, 28:] = 128  # zero
    rows[3:5, 28:] = [255, 255, 255, 255]
    told = reasons(written("y.splat", rows.tobytes()))
    assert (told[NONE], told[UNEVEN]) == (3, 2)


def test_what_is_farther_than_can_be_encoded_is_left_out() -> None:
    given = statics()
    given.means[:2, 1] = [1e31, -3e38]
    static, _, changes = drawable(given, [DynamicSplats.empty()])
    assert len(static) == 48
    assert [(change.count, change.reason) for change in changes if change.count] == [(2, "position is beyond 1e+30")]
    dynamic = dynamics()
    dynamic.motion[4, 2, 0] = 1e31
    assert len(drawable(StaticSplats.empty(), [dynamic])[1][0]) == 29


def test_a_good_scene_stays_as_it_is() -> None:
    given, moving = statics(), dynamics()
    opaque = dataclasses.replace(given, opacity_logits=np.clip(given.opacity_logits, -5, 5))
    unit = moving.rotation / np.linalg.norm(moving.rotation[:, :1], axis=2, keepdims=True)
    static, (dynamic,), changes = drawable(opaque, [dataclasses.replace(moving, rotation=unit)])
    assert [change for change in changes if change.count] == []
    np.testing.assert_array_equal(static.quats, opaque.quats)
    np.testing.assert_allclose(dynamic.rotation, unit, rtol=1e-6)
