from __future__ import annotations

import dataclasses

import numpy as np

from hgs_core.edit.floaters import drop_floaters, floating
from hgs_core.scene import HybridScene, Segment, StaticSplats
from tests.hgs_core.edit.scenes import dynamics, moving


def cloud(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    return rng.normal(0, 1, (1000, 3)), np.full(1000, 0.05)


def test_what_stands_alone_floats_and_a_sparse_sky_of_large_splats_does_not() -> None:
    rng = np.random.default_rng(0)
    places, sizes = cloud(rng)
    alone = np.array([[20.0, 0, 0], [0, 25, 0], [0, 0, -30]])
    sky = rng.normal(size=(150, 3))
    sky *= 60 / np.linalg.norm(sky, axis=1, keepdims=True)
    found = floating(np.concatenate([places, alone, sky]), np.concatenate([sizes, np.full(3, 0.1), np.full(150, 15.0)]))
    np.testing.assert_array_equal(np.flatnonzero(found), [1000, 1001, 1002])


def test_splats_alone_but_as_large_as_their_distance_stay() -> None:
    places, sizes = cloud(np.random.default_rng(1))
    places, sizes = np.concatenate([places, [[30.0, 0, 0]]]), np.concatenate([sizes, [10.0]])
    assert not floating(places, sizes).any()


def test_among_few_splats_none_floats() -> None:
    assert not floating(np.array([[0.0, 0, 0], [9, 9, 9]]), np.array([0.1, 0.1])).any()
    assert floating(np.zeros((0, 3)), np.zeros(0)).shape == (0,)


def test_still_and_moving_floaters_are_left_out_and_counted() -> None:
    """A moving splat is judged in the middle of its visible life, apart from its polynomial's start."""
    rng = np.random.default_rng(2)
    places, sizes = cloud(rng)
    places[:2] = [[40, 0, 0], [0, 40, 0]]
    arrays = (
        places,
        np.log(np.repeat(sizes[:, None], 3, 1)),
        rng.normal(size=(1000, 4)),
        np.ones(1000),
        np.ones((1000, 3)),
    )
    static = StaticSplats(*(array.astype(np.float32) for array in arrays))
    dynamic = dynamics(rng, 3)
    dynamic.motion[:] = 0
    dynamic.motion[0, 1, 0] = 90.0  # far away at t = 0.5, half a segment after its centre
    dynamic.motion[1, 0, 0] = 90.0
    dynamic.motion[1, 1, 0] = -180.0  # among the others then
    dynamic.time_centers[:], dynamic.time_log_precisions[:], dynamic.opacity_logits[:] = 0, -20, 3
    dynamic.log_scales[:] = np.log(0.05)
    viewed = dataclasses.replace(moving(), scene=HybridScene(static, (Segment(0.0, 1.0, dynamic),)))
    edit = drop_floaters(viewed)
    assert (len(edit.viewed.scene.static), edit.viewed.scene.dynamic_splats) == (998, 2)
    assert [(c.count, c.of) for c in edit.changes] == [(3, 1003)]
    assert "stand alone" in edit.changes[0].reason
