"""A merged scene against the union of both scenes' splats at the same moment, drawn by the reference in float64."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import torch

from hgs_core.base.errors import InputError
from hgs_core.edit.merge import merge
from hgs_core.edit.viewed_scene import ViewedScene
from hgs_core.interchange.moment import scene_at
from hgs_core.render.rasterize import rasterize
from hgs_core.scene.splats import joined
from tests.hgs_core.edit.scenes import CAMERAS, moving, picture, splats, still
from tests.tolerances import TOLERANCES

RTOL, ATOL = TOLERANCES["float32"]


def union(a: ViewedScene, b: ViewedScene, seconds: float, other: float) -> np.ndarray:
    """Both scenes' splats, each at its own second; nothing that moves of a scene that is over or has not begun."""

    def then(viewed: ViewedScene, moment: float):  # type: ignore[no-untyped-def]
        scene = viewed.scene
        return scene_at(scene, moment) if scene.start <= moment < scene.end else scene.static

    both = joined([then(a, seconds), then(b, other)]).map(lambda array: torch.from_numpy(np.float64(array)))
    drawn = rasterize(
        both, None, CAMERAS[1], backend="reference", gradients="none", background=a.scene.background
    )  # fmt: skip
    return drawn.rgb.numpy()


@pytest.mark.parametrize("at", [2.0, 2.9, 6.0])
def test_a_merged_scene_shows_both(at: float) -> None:
    """Begun together, overlapping in part, and one after the other with a pause between them."""
    a, b = moving(0), moving(1, coefficients=6)
    merged = merge(a, b, at).viewed
    for seconds in (2.3, 3.0, 3.65, 4.9, 5.2, 5.6, 6.3, 8.0):
        if seconds < merged.scene.end:
            expected = union(a, b, seconds, seconds - at + 2.0)
            np.testing.assert_allclose(picture(merged, CAMERAS[1], seconds), expected, RTOL, 5 * ATOL)


def test_a_still_scene_stays_for_all_time_and_leaves_segments_as_they_are() -> None:
    a, b = moving(), still()
    for merged in (merge(a, b).viewed, merge(b, a).viewed):
        assert len(merged.scene.static) == 240
        assert [len(s.dynamic) for s in merged.scene.segments] == [60, 60]
        np.testing.assert_array_equal(merged.scene.segments[1].dynamic.motion, a.scene.segments[1].dynamic.motion)
    assert merge(b, a).viewed.scene.start == 0.0  # on the clock of the first


def test_two_still_scenes_make_one() -> None:
    merged = merge(still(1), still(2)).viewed
    assert (splats(merged), merged.scene.start, merged.scene.end) == (240, 0.0, 0.0)


def test_copies_on_both_sides_of_a_cut_are_counted() -> None:
    a, b = moving(0), moving(1)
    edit = merge(a, b, 2.9)
    told = [change for change in edit.changes if change.what == "segments"]
    assert told[0].count == splats(edit.viewed) - splats(a) - splats(b) > 0


def test_cameras_of_both_are_there_under_names_of_their_own() -> None:
    edit = merge(moving(), still())
    assert [camera.name for camera in edit.viewed.cameras] == ["0", "1", "2", "0-2"]
    assert "1 of the second have names of the first" in str(edit.changes[-1])


def test_what_is_drawn_otherwise_is_refused() -> None:
    with pytest.raises(InputError, match="--merge: was trained to be drawn antialiased, and the scene to be not drawn"):
        merge(moving(), moving(antialiased=True))
    other = still()
    dark = dataclasses.replace(other, scene=dataclasses.replace(other.scene, background=(0.0, 0.0, 0.0)))
    with pytest.raises(InputError, match=r"--merge: has the background 0,0,0, and the scene 0.2,0.1,0.3"):
        merge(moving(), dark)


def test_a_beginning_before_the_scene_or_too_near_to_a_border_is_refused() -> None:
    with pytest.raises(InputError, match="--at: 1 s is before the scene begins"):
        merge(moving(), moving(1), 1.0)
    with pytest.raises(InputError, match="--merge: leaves a segment of only"):
        merge(moving(), moving(1), 2.00001)
