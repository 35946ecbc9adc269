from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hgs_core.ablate.summary import FIGURES, summarise


def scores(**some: float | None) -> dict[str, Any]:
    """The eval.json of one run."""
    return dict.fromkeys(FIGURES, 1.0) | some


def test_means_and_deviations_are_those_of_numpy() -> None:
    values = [27.1, 27.4, 26.2]
    full, _ = summarise({"full": {s: scores(psnr=v) for s, v in enumerate(values)}, "order-1": {0: scores()}})
    assert full.mean["psnr"] == pytest.approx(np.mean(values))
    assert full.deviation["psnr"] == pytest.approx(np.std(values, ddof=1))
    assert full.deviation["ssim"] == 0
    assert [run["seed"] for run in full.runs] == [0, 1, 2]


def test_a_single_seed_has_no_deviation_and_what_a_run_lacks_has_no_mean() -> None:
    (full,) = summarise({"full": {4: scores(psnr_dynamic=None)}})
    assert (full.mean["psnr"], full.deviation["psnr"]) == (1.0, None)
    assert (full.mean["psnr_dynamic"], full.deviation["psnr_dynamic"]) == (None, None)
    assert (full.psnr_difference, full.needs_seeds) == (None, False)


def test_differences_are_between_runs_of_the_same_seed() -> None:
    full = {0: scores(psnr=20.0), 1: scores(psnr=30.0)}
    _, row = summarise({"full": full, "order-1": {1: scores(psnr=29.0)}})
    assert row.psnr_difference == pytest.approx(-1.0)


@pytest.mark.parametrize(
    ("difference", "seeds", "needs"),
    [(0.4, 1, True), (-0.4, 2, True), (0.4, 3, False), (0.5, 1, False), (-3.0, 1, False)],
)
def test_small_differences_need_three_seeds(difference: float, seeds: int, needs: bool) -> None:
    full = {seed: scores(psnr=20.0) for seed in range(seeds)}
    _, row = summarise({"full": full, "order-1": {seed: scores(psnr=20.0 + difference) for seed in full}})
    assert row.needs_seeds is needs
