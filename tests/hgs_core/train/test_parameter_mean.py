"""The mean of splats over several moments of a training; numpy's mean of all of them is the reference."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.parameter_mean import ParameterMean
from tests.hgs_core.render.scenes import dynamic_splats, static_splats


def test_the_mean_is_that_of_all_splats_that_were_added() -> None:
    sets = [dynamic_splats(6, seed, dtype=torch.float32) for seed in range(4)]
    mean: ParameterMean[DynamicSplats[Tensor]] = ParameterMean()
    for splats in sets:
        mean.follow(splats)
    for name, array in mean.of(sets[0]).items():
        expected = np.mean([getattr(splats, name).numpy().astype(np.float64) for splats in sets], axis=0)
        assert array.dtype == torch.float32
        np.testing.assert_array_equal(array.numpy(), expected.astype(np.float32), err_msg=name)


def test_splats_that_go_on_in_place_leave_the_sums_alone() -> None:
    splats = static_splats(5)  # float64, as the sums are
    before = splats.map(lambda array: array.float())
    mean: ParameterMean[StaticSplats[Tensor]] = ParameterMean()
    mean.follow(splats)
    splats.rgb.add_(1)
    assert torch.equal(mean.of(splats).rgb, before.rgb)


def test_a_thousand_times_the_same_is_the_same_bit_for_bit() -> None:
    splats = static_splats(7, dtype=torch.float32)
    mean: ParameterMean[StaticSplats[Tensor]] = ParameterMean()
    for _ in range(1000):
        mean.follow(splats)
    for name, array in mean.of(splats).items():
        assert torch.equal(array, getattr(splats, name)), name


def test_without_anything_added_the_splats_stay_themselves() -> None:
    splats = static_splats(3, dtype=torch.float32)
    assert ParameterMean().of(splats) is splats


def test_a_mean_that_was_kept_goes_on_as_if_it_had_never_stopped(tmp_path: Path) -> None:
    first, second = (dynamic_splats(4, seed, dtype=torch.float32, coefficients=6) for seed in (1, 2))
    mean: ParameterMean[DynamicSplats[Tensor]] = ParameterMean()
    mean.follow(first)
    torch.save(mean.state(), tmp_path / "mean.pt")
    back = ParameterMean.restored(DynamicSplats, torch.load(tmp_path / "mean.pt", weights_only=True))
    for one in (mean, back):
        one.follow(second)
    for name, array in back.of(second).items():
        assert torch.equal(array, getattr(mean.of(second), name)), name
    assert ParameterMean.restored(StaticSplats, ParameterMean().state()) == ParameterMean()
