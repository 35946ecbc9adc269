from __future__ import annotations

import math
from pathlib import Path

import pytest
import torch

from hgs_core.base.errors import InputError
from hgs_core.evaluate import picture_scores
from hgs_core.evaluate.picture_scores import PICTURE_METRICS, REGION_METRICS, RIG_METRICS, PictureScorer
from hgs_core.metrics.ms_ssim import SMALLEST_SIDE


def test_scores_stand_under_their_names_and_unwanted_ones_are_none() -> None:
    """References: pictures that differ by 0.1 everywhere have 20 dB; equal ones have structural similarity 1."""
    truth = torch.rand(3, SMALLEST_SIDE, SMALLEST_SIDE, generator=torch.Generator().manual_seed(0)) * 0.8
    scorer = PictureScorer(None, with_flip=False)
    scores = scorer.score(truth + 0.1, truth)
    assert set(scores) == {*PICTURE_METRICS, *REGION_METRICS}
    assert scores["psnr"] == pytest.approx(20.0, abs=1e-4)
    assert (scores["lpips"], scores["flip"]) == (None, None)
    equal = scorer.score(truth, truth)
    assert equal["psnr"] == math.inf
    assert (equal["ssim"], equal["ms_ssim"]) == (pytest.approx(1.0), pytest.approx(1.0))


def test_the_rig_is_scored_by_the_same_metrics_without_the_costliest() -> None:
    pair = torch.rand(2, 3, SMALLEST_SIDE, SMALLEST_SIDE, generator=torch.Generator().manual_seed(0))
    moving = pair[0, 0] > 0.5
    scorer = PictureScorer(None, with_flip=False)
    scores, as_rig = scorer.score(*pair, moving), scorer.score_as_rig(*pair, moving)
    assert set(as_rig) == {*RIG_METRICS, *REGION_METRICS}
    assert as_rig == {name: scores[name] for name in as_rig}


def test_a_metric_that_is_not_defined_for_so_small_a_picture_is_none() -> None:
    small = torch.zeros(3, SMALLEST_SIDE - 1, SMALLEST_SIDE)
    assert PictureScorer(None, with_flip=False).score(small, small)["ms_ssim"] is None


def test_costly_metrics_are_taken_where_they_are_wanted(monkeypatch: pytest.MonkeyPatch) -> None:
    loaded: list[Path] = []
    monkeypatch.setattr(picture_scores, "Lpips", lambda path: loaded.append(path) or (lambda image, truth: 0.25))
    monkeypatch.setattr(picture_scores, "require_flip", lambda: None)
    monkeypatch.setattr(picture_scores, "flip", lambda image, truth: 0.125)
    small = torch.zeros(3, 8, 8)
    scores = PictureScorer(Path("weights"), with_flip=True).score(small, small)
    assert (loaded, scores["lpips"], scores["flip"]) == ([Path("weights")], 0.25, 0.125)


def test_weights_that_are_missing_are_told_before_a_picture_is_scored(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="absent"):
        PictureScorer(tmp_path / "absent", with_flip=False)
