from __future__ import annotations

import numpy as np
import torch

from hgs_core.train.rmsprop import RmsProp
from hgs_core.train.splat_sets import joined, kept, rows_of
from tests.hgs_core.render.scenes import dynamic_splats, static_splats


def test_joined_sets_have_all_rows_in_order() -> None:
    one, two = dynamic_splats(3), dynamic_splats(2, seed=5)
    for name, array in joined(one, two).items():
        np.testing.assert_array_equal(array.numpy(), np.concatenate([getattr(one, name), getattr(two, name)]))


def test_what_is_kept_keeps_its_moments_and_what_is_added_has_none() -> None:
    splats, added = static_splats(4), static_splats(2, seed=5)
    optimiser = RmsProp.of(splats)
    optimiser.moments.rgb[:] = torch.arange(4.0)[:, None]
    result = kept(splats, optimiser, np.array([True, False, False, True]), added)
    np.testing.assert_array_equal(result.means.numpy(), np.concatenate([splats.means[[0, 3]], added.means]))
    assert optimiser.moments.rgb[:, 0].tolist() == [0, 3, 0, 0]
    assert len(optimiser.moments) == 4


def test_without_a_mask_all_are_kept() -> None:
    splats = static_splats(3)
    assert torch.equal(kept(splats, RmsProp.of(splats), None).means, splats.means)


def test_rows_are_those_that_the_mask_marks() -> None:
    assert rows_of(np.array([False, True, True, False])).tolist() == [1, 2]
