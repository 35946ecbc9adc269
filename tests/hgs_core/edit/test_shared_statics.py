"""The shared statics of two scenes."""

from __future__ import annotations

import dataclasses

import numpy as np

from hgs_core.edit.shared_statics import shared_statics
from hgs_core.scene import StaticSplats
from hgs_core.scene.splats import joined
from tests.hgs_core.edit.scenes import statics


def set_of(seed: int, count: int = 400) -> StaticSplats[np.ndarray]:
    given = statics(np.random.default_rng(seed), count)
    return dataclasses.replace(given, opacity_logits=np.abs(given.opacity_logits) + 1)


def again(given: StaticSplats[np.ndarray]) -> StaticSplats[np.ndarray]:
    """Another training of the same set."""
    beside = np.random.default_rng(9).normal(0, 0.2, given.means.shape) * np.exp(given.log_scales.min(1, keepdims=True))
    return dataclasses.replace(given, means=(given.means + beside).astype(np.float32))


def test_scenes_of_different_sets_are_both_always_shown() -> None:
    found = shared_statics(set_of(0), set_of(1))
    assert (len(found.always), found.by_time, found.twice) == (800, 0, 0)


def test_two_trainings_of_one_set_are_shown_by_time() -> None:
    found = shared_statics(set_of(0), again(set_of(0)))
    assert (len(found.always), len(found.first), len(found.second)) == (0, 400, 400)


def test_a_part_of_the_set_is_shown_by_time_and_the_rest_always() -> None:
    found = shared_statics(set_of(0), again(set_of(0)).take(slice(0, 80)))
    assert len(found.second) == 80
    assert 80 <= len(found.first) < 200
    assert len(found.always) == 400 - len(found.first)


def test_what_is_the_same_to_the_bit_is_kept_once() -> None:
    found = shared_statics(set_of(0), joined([set_of(0), set_of(1)]))
    assert (len(found.always), found.by_time, found.twice) == (800, 0, 400)


def test_scenes_without_static_splats_share_none() -> None:
    none = StaticSplats.empty()
    assert len(shared_statics(none, none).always) == 0
    assert len(shared_statics(set_of(0), none).always) == 400
