"""A merged scene against the union of both scenes' splats at the same moment, drawn by the reference in float64."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import torch

from hgs_core.base.errors import InputError
from hgs_core.edit.crop import crop
from hgs_core.edit.merge import merge
from hgs_core.edit.regions import box_of
from hgs_core.edit.trim import trim
from hgs_core.edit.viewed_scene import ViewedScene
from hgs_core.interchange.still_moment import scene_at
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
    drawn = rasterize(both, None, CAMERAS[1], backend="reference", gradients="none", background=a.scene.background)
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
    assert merge(b, a).viewed.scene.start == 0.0  # the first one's clock


def test_two_still_scenes_make_one() -> None:
    merged = merge(still(1), still(2)).viewed
    assert (splats(merged), merged.scene.start, merged.scene.end) == (240, 0.0, 0.0)


def take(viewed: ViewedScene, seed: int = 0) -> ViewedScene:
    """Another training of the same set: a tenth of the splats less, others a little beside, of nearly their colour."""
    rng = np.random.default_rng(seed)
    given = viewed.scene.static
    kept = given.take(rng.random(len(given)) < 0.9)
    means = kept.means + rng.normal(0, 0.2, kept.means.shape) * np.exp(kept.log_scales.min(axis=1, keepdims=True))
    rgb = kept.rgb + rng.uniform(-0.05, 0.05, kept.rgb.shape)
    static = dataclasses.replace(kept, means=means.astype(np.float32), rgb=rgb.astype(np.float32))
    return dataclasses.replace(viewed, scene=dataclasses.replace(viewed.scene, static=static))


def same(merged: ViewedScene, seconds: float, alone: ViewedScene, at: float) -> None:
    np.testing.assert_allclose(picture(merged, CAMERAS[1], seconds), picture(alone, CAMERAS[1], at), RTOL, 5 * ATOL)


@pytest.mark.parametrize("at", [6.0, 5.3, 4.0])
def test_two_takes_of_one_set_show_each_its_own_at_its_time(at: float) -> None:
    """After one another, with a pause and without, and overlapping: then the first one's set is shown."""
    a = moving(0)
    b = take(moving(0))
    edit = merge(a, b, at)
    same(edit.viewed, 2.5, a, 2.5)
    if at >= 5.3:
        same(edit.viewed, 5.2, a, 5.2)
        same(edit.viewed, at + 0.9, b, 2.9)
    else:
        same(edit.viewed, 5.9, b, 5.9 - at + 2.0)
    (told,) = [change for change in edit.changes if change.what == "static splats"]
    assert told.count == len(a.scene.static) + len(b.scene.static)
    assert "the second's while it alone lasts, else the first's" in str(told)


def test_what_both_have_to_the_bit_is_kept_once() -> None:
    """A take that was cut out of the other."""
    a = moving(0)
    later = trim(a, 2.2, 3.2).viewed
    edit = merge(a, later, 5.3)
    assert len(edit.viewed.scene.static) == len(a.scene.static)
    assert (edit.changes[0].count, edit.changes[0].reason) == (120, "both scenes have them")
    for seconds in (2.4, 5.2):
        same(edit.viewed, seconds, a, seconds)
    same(edit.viewed, 5.7, a, 2.6)


def test_what_moved_between_the_takes_is_where_each_has_it() -> None:
    """A chair of a tenth of the splats that stands elsewhere in the second take."""
    a = moving(0)
    b = take(moving(0))
    b.scene.static.means[:10] += 3.0
    edit = merge(a, b, 6.0)
    same(edit.viewed, 5.2, a, 5.2)
    same(edit.viewed, 6.9, b, 2.9)


def test_a_still_scene_of_the_same_set_is_refused_with_a_cure() -> None:
    a = moving(0)
    b = dataclasses.replace(still(), scene=dataclasses.replace(still().scene, static=take(moving(0)).scene.static))
    for first, second in ((a, b), (b, a)):
        with pytest.raises(InputError, match=r"--merge: .* fill the same places.*; cut out of one of them"):
            merge(first, second)
    outside = crop(b, box_of([0, 0, 0, 4, 4, 4]), inverse=False).viewed
    left = crop(a, box_of([0, 0, 0, 4, 4, 4]), inverse=True, touching=True).viewed
    assert len(merge(left, outside).viewed.scene.static) == len(outside.scene.static)  # the cure


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
