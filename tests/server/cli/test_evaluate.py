from __future__ import annotations

import json
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.evaluate.score_table import SCORE_COLUMNS, score_lines
from hgs_core.runs.run_folder import RunFolder
from server.cli import main

SCORES: dict[str, Any] = {
    "psnr": 27.5,
    "psnr_dynamic": None,
    "ssim": 0.875,
    "ssim_dynamic": None,
    "lpips": None,
    "lpips_dynamic": None,
    "psnr_rig": 28.25,
    "psnr_dynamic_rig": None,
    "ssim_rig": 0.88,
    "ssim_dynamic_rig": None,
    "lpips_rig": None,
    "lpips_dynamic_rig": None,
    "psnr_colour_corrected": 28.5,
    "psnr_dynamic_colour_corrected": 26.25,
    "psnr_lens_corrected": 28.75,
    "psnr_dynamic_lens_corrected": None,
    "lpips_network": None,
    "lens_falloff": [-0.1, 0.0],
    "colour_map": None,
    "psnr_static": None,
    "ms_ssim": 0.96,
    "flip": None,
    "flicker": 0.004,
    "flicker_steady": 0.003,
    "magnified": None,
    "bytes_total": 300,
    "bytes_static": 200,
    "bytes_dynamic": 90,
    "splats_static": 20,
    "splats_dynamic": 9,
    "train_seconds": 12.5,
    "frames": 60,
    "cameras": ["cam00"],
    "cameras_trained_on": [],
}


@pytest.fixture(autouse=True)
def wishes(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Replace the evaluation with one of these scores and more; return its requests."""
    asked: dict[str, Any] = {}

    def evaluate_run(run: Path, progress: ProgressCallback, **options: Any) -> dict[str, Any]:
        asked.update(options)
        progress(Progress("evaluate", 1, 1))
        return {"per_frame": {"cam00": {"psnr": [27.5]}}, **SCORES}

    monkeypatch.setitem(sys.modules, "hgs_core.evaluate.run", SimpleNamespace(evaluate_run=evaluate_run))  # type: ignore[arg-type]
    monkeypatch.setattr(RunFolder, "read_spec", lambda self: None)
    return asked


def test_json_is_one_object_of_exactly_the_documented_fields(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["eval", str(tmp_path), "--json"]) == 0
    output = json.loads(capsys.readouterr().out)
    assert output == SCORES
    assert tuple(output) == SCORE_COLUMNS


def test_text_is_a_table_of_the_same_scores(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["eval", str(tmp_path)]) == 0
    assert capsys.readouterr().out.splitlines() == score_lines(SCORES)


def test_what_lpips_lacks_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["eval", str(tmp_path)]) == 0
    assert "no LPIPS: give its weights with --lpips FILE" in capsys.readouterr().err
    assert main(["eval", str(tmp_path), "--lpips", "weights.npz"]) == 0
    assert "no LPIPS" not in capsys.readouterr().err


def test_by_default_the_cheap_metrics_of_the_held_out_cameras_are_asked_for(
    tmp_path: Path, wishes: dict[str, Any]
) -> None:
    assert main(["eval", str(tmp_path)]) == 0
    assert wishes == {
        "cameras": None,
        "all_cameras": False,
        "truth": None,
        "masks": None,
        "lpips": None,
        "flip": False,
        "magnify": [],
        "backend": "auto",
    }


def test_the_options_reach_the_evaluation(tmp_path: Path, wishes: dict[str, Any]) -> None:
    options = ["--truth", "t", "--masks", "m", "--lpips", "w.npz", "--flip", "--cameras", "a, b,", "--backend", "cpu"]
    options += ["--magnify", "4,2"]
    assert main(["eval", str(tmp_path), *options]) == 0
    assert wishes == {
        "cameras": ["a", "b"],
        "all_cameras": False,
        "truth": Path("t"),
        "masks": Path("m"),
        "lpips": Path("w.npz"),
        "flip": True,
        "magnify": [2, 4],
        "backend": "cpu",
    }
    assert main(["eval", str(tmp_path), "--all-cameras"]) == 0
    assert wishes["all_cameras"]


def test_factors_that_are_no_numbers_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["eval", str(tmp_path), "--magnify", "2x"]) == 2
    assert "--magnify: '2x' is not a list of whole numbers" in capsys.readouterr().err


def test_naming_no_camera_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["eval", str(tmp_path), "--cameras", ","]) == 2
    assert "--cameras: names no camera" in capsys.readouterr().err
