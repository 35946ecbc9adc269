"""Deletions told from other edits by the splats that are left."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hgs_core.edit.deletion import deletion_of
from hgs_core.edit.orient import Similarity, orient, turn_about
from hgs_core.edit.trim import trim
from hgs_core.edit.viewed_scene import ViewedScene
from hgs_core.scene import HybridScene, Segment
from tests.hgs_core.edit.scenes import CAMERAS, SPANS, dynamics, statics

RNG = np.random.default_rng(2)
SCENE = HybridScene(statics(RNG), tuple(Segment(*span, dynamics(RNG)) for span in SPANS))
BEFORE = ViewedScene(SCENE, CAMERAS, np.linspace(SPANS[0][0], SPANS[1][1], 34))


def without(static: np.ndarray, *moving: np.ndarray) -> ViewedScene:
    pairs = zip(SCENE.segments, moving, strict=True)
    segments = tuple(dataclasses.replace(one, dynamic=one.dynamic.take(mask)) for one, mask in pairs)
    return dataclasses.replace(
        BEFORE, scene=dataclasses.replace(SCENE, static=SCENE.static.take(static), segments=segments)
    )


@pytest.mark.parametrize("share", [0.0, 0.4, 1.0])
def test_a_deletion_tells_the_splats_that_are_left(share: float) -> None:
    masks = [RNG.random(count) < share for count in (len(SCENE.static), *(len(s.dynamic) for s in SCENE.segments))]
    found = deletion_of(BEFORE, without(*masks))
    assert found is not None
    for mask, wanted in zip((found.static, *found.moving), masks, strict=True):
        np.testing.assert_array_equal(mask, wanted)


def test_equal_splats_are_told_apart_by_their_number() -> None:
    twice = dataclasses.replace(SCENE, static=SCENE.static.take([0, 1, 0, 0]))
    before = dataclasses.replace(BEFORE, scene=twice)
    after = dataclasses.replace(before, scene=dataclasses.replace(twice, static=twice.static.take([0, 2])))
    found = deletion_of(before, after)
    assert found is not None
    assert found.static.tolist() == [True, False, True, False]


@pytest.mark.parametrize(
    "changed",
    [
        trim(BEFORE, 2.5, 5.0).viewed,
        orient(BEFORE, Similarity(turn_about([0, 1, 0, 30]), 1.0, np.zeros(3))).viewed,
        dataclasses.replace(BEFORE, scene=dataclasses.replace(SCENE, static=SCENE.static.take([1, 0]))),
        dataclasses.replace(BEFORE, scene=dataclasses.replace(SCENE, static=SCENE.static.take([0, 0]))),
        dataclasses.replace(BEFORE, begins=1.0),
        dataclasses.replace(BEFORE, times=BEFORE.times[1:]),
    ],
    ids=["trimmed", "turned", "in another order", "doubled", "later", "fewer frames"],
)
def test_another_edit_is_none(changed: ViewedScene) -> None:
    assert deletion_of(BEFORE, changed) is None
