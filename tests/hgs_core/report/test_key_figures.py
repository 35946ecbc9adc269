"""Figures against those of eval.json, which knows nothing of the report."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from hgs_core.base.progress import silent
from hgs_core.report.key_figures import config_changes, key_figures, megabytes, per_frames
from hgs_core.report.sources import FinishedRun, read_run
from hgs_core.runs.run_config import RunConfig


@pytest.fixture(scope="module")
def finished(run: Path) -> FinishedRun:
    return read_run(run, silent)


def values(run: FinishedRun) -> dict[str, str]:
    return {figure.key: figure.value for figure in key_figures(run)}


def test_figures_are_those_of_eval_json(run: Path, finished: FinishedRun) -> None:
    shown, scores = values(finished), json.loads((run / "eval.json").read_text())
    assert shown["psnr"] == f"{scores['psnr']:.2f}"
    assert shown["ssim"] == f"{scores['ssim']:.4f}"
    assert shown["bytes_total"] == f"{scores['bytes_total'] / 1e6:.3f}"
    assert shown["mb_50"] == f"{scores['bytes_total'] / scores['frames'] * 50 / 1e6:.3f}"
    assert shown["mb_300"] == f"{scores['bytes_total'] / scores['frames'] * 300 / 1e6:.3f}"
    assert shown["splats"] == f"{scores['splats_static'] + scores['splats_dynamic']:,}"


def test_figures_through_the_lens_are_shown_where_one_was_learned(finished: FinishedRun) -> None:
    scores = {"psnr": 27.0, "psnr_dynamic": 25.0, "psnr_rig": 28.0, "psnr_dynamic_rig": 26.0}
    with_lens = values(replace(finished, scores={**scores, "lens_falloff": [-0.1, 0.0]}))
    without = values(replace(finished, scores={**scores, "lens_falloff": None}))
    assert list(with_lens)[:4] == ["psnr", "psnr_dynamic", "psnr_rig", "psnr_dynamic_rig"]
    assert (with_lens["psnr_rig"], with_lens["psnr_dynamic_rig"]) == ("28.00", "26.00")
    assert [name for name in without if name.endswith("_rig")] == []


def test_time_and_speed_are_those_of_training(finished: FinishedRun) -> None:
    """40 iterations in 12 seconds."""
    assert (values(finished)["minutes"], values(finished)["rate"]) == ("0.2", "3.3")
    assert "rate" not in values(replace(finished, seconds=0.0))


def test_what_was_not_measured_is_not_shown(finished: FinishedRun) -> None:
    unscored = values(replace(finished, scores={"psnr": None, "ssim": float("nan"), "frames": 1}))
    assert list(unscored) == ["bytes_total", "splats", "minutes", "rate"]


def test_a_size_that_was_scaled_says_from_what(finished: FinishedRun) -> None:
    notes = {figure.key: figure.note for figure in key_figures(replace(finished, scores={"frames": 50}))}
    assert (notes["mb_50"], notes["mb_300"]) == ("", "scaled from 50 frames")


def test_sizes_are_scaled_by_frames_and_counted_in_millions() -> None:
    assert per_frames(300.0, 60, 50) == 250.0
    assert megabytes(2_500_000) == 2.5


def test_changes_are_the_fields_that_differ_from_the_preset() -> None:
    assert config_changes(RunConfig.for_preset("best", capture={"hold_out": ["a"]})) == []
    preset = RunConfig.for_preset("preview")
    changed = config_changes(RunConfig.for_preset("preview", train={"iterations": 7}))
    assert changed == [("train.iterations", str(preset.train.iterations), "7")]


def test_fields_of_parts_are_named_with_them() -> None:
    ((name, _, value),) = config_changes(RunConfig.for_preset("preview", train={"learning_rates": {"opacity": 0.5}}))
    assert (name, value) == ("train.learning_rates.opacity", "0.5")
