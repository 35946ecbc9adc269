from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from hgs_core.base.progress import silent
from hgs_core.report.chart_sections import (
    comparable,
    comparison_section,
    decomposition_section,
    quality_section,
    training_section,
)
from hgs_core.report.sources import FinishedRun, read_run

Scored = Callable[..., FinishedRun]


@pytest.fixture(scope="module")
def finished(run: Path) -> FinishedRun:
    return read_run(run, silent)


@pytest.fixture(scope="module")
def foreign(other: Path) -> FinishedRun:
    return read_run(other, silent)


@pytest.fixture
def scored(finished: FinishedRun) -> Scored:
    """Return a function that makes the run one with other scores."""

    def make(**scores: Any) -> FinishedRun:
        return replace(finished, scores={**finished.scores, **scores})

    return make


def test_quality_shows_each_camera_with_its_mean_and_its_worst_frame(scored: Scored) -> None:
    run = scored(per_frame={"a": {"psnr": [30.0, 20.0, None]}, "b": {"psnr": [40.0, 40.0, 40.0]}})
    html = quality_section(run, [], [0.0, 0.5, 1.0])
    assert "a: 25.00 dB" in html
    assert "a: worst frame 20.00 dB" in html
    assert "b: 40.00 dB" in html
    assert "a\nseconds 0.5: 20 dB" in html


def test_without_the_capture_quality_is_shown_by_frame(scored: Scored) -> None:
    assert "a\nframe 1: 20 dB" in quality_section(scored(per_frame={"a": {"psnr": [30.0, 20.0]}}), [], [])


def test_of_very_many_cameras_the_lowest_are_shown(scored: Scored) -> None:
    html = quality_section(scored(per_frame={f"c{k}": {"psnr": [20.0 + k]} for k in range(50)}), [], [])
    assert "The lowest 40 of 50." in html
    assert "c39: 59.00 dB" in html
    assert "c40: 60.00 dB" not in html


def test_quality_without_scores_says_why(finished: FinishedRun) -> None:
    html = quality_section(replace(finished, scores={}, unscored="capture: is gone"), [], [])
    assert "No scores: capture: is gone." in html


def test_cameras_that_training_saw_are_told(scored: Scored, finished: FinishedRun) -> None:
    (held_out,) = finished.spec.config.capture.hold_out
    one = quality_section(scored(per_frame={held_out: {"psnr": [30.0]}}), [], [])
    both = quality_section(scored(per_frame={held_out: {"psnr": [30.0]}, "0": {"psnr": [30.0]}}), [], [])
    assert "Cameras that neither initialisation nor training saw." in one
    assert "Training saw 0." in both


def test_training_shows_its_curves_and_where_the_time_went(finished: FinishedRun) -> None:
    """12 seconds, of which 11 have a name."""
    html = training_section(finished)
    for title in ("PSNR of training views", "Loss", "Splats", "Where the time went"):
        assert f"<figcaption>{title}</figcaption>" in html
    assert "all step: 8.0 s, 67%" in html
    assert "everything else: 1.0 s, 8%" in html
    assert "has no" not in html


def test_training_that_recorded_nothing_says_so(foreign: FinishedRun) -> None:
    assert "train.json of this run has no history and no profile." in training_section(foreign)


def test_shares_of_what_moves_are_those_of_the_manifest(finished: FinishedRun) -> None:
    totals = finished.manifest.totals
    html = decomposition_section(finished, [])
    for name, dynamic, static in (
        ("splats", totals.splats_dynamic, totals.splats_static),
        ("bytes", totals.bytes_dynamic, totals.bytes_static),
    ):
        assert f"{name}, dynamic: {dynamic / (dynamic + static):.1%}" in html
    assert "pixels" not in html  # there are no pictures to count them in


def test_without_other_runs_the_comparison_says_how_to_get_one(finished: FinishedRun) -> None:
    assert "--against" in comparison_section(finished, [])


def test_a_comparison_marks_the_run_that_is_not_comparable(finished: FinishedRun, foreign: FinishedRun) -> None:
    html = comparison_section(finished, [foreign])
    row = re.search(rf'<tr><th scope="row">{foreign.name}</th>(.*?)</tr>', html)
    assert row
    assert row[1].endswith("<td>no</td>")
    assert "Hollow points were scored on another capture" in html
    assert "Hollow points" not in comparison_section(finished, [finished])


def test_a_comparison_has_what_moves_and_the_lens_beside_the_raw_score(finished: FinishedRun, scored: Scored) -> None:
    scores = {"psnr": 27.0, "psnr_dynamic": 25.0, "psnr_rig": 28.0, "ssim": 0.5, "ssim_dynamic": 0.25}
    html = comparison_section(finished, [replace(scored(**scores), name="other")])
    cells = "<td>27.00</td><td>25.00</td><td>28.00</td><td>0.5000</td><td>0.2500</td>"
    assert f'<th scope="row">other</th><td>preview</td>{cells}' in html


def test_runs_of_one_name_are_told_apart_by_their_folders(finished: FinishedRun) -> None:
    html = comparison_section(finished, [finished])
    assert html.count(f'<th scope="row">{finished.folder.path.parent.name}/{finished.name}</th>') == 2


@pytest.mark.parametrize(
    "scores", [{"cameras": ["1"]}, {"frames": 3}, {"truth": "given"}, {"cameras_trained_on": ["2"]}]
)
def test_runs_are_comparable_if_scored_on_the_same_pictures(
    finished: FinishedRun, scored: Scored, scores: dict[str, Any]
) -> None:
    assert comparable(finished, scored(psnr=99.0))
    assert not comparable(finished, scored(**scores))


def test_runs_without_a_score_are_in_the_table_alone(finished: FinishedRun, scored: Scored) -> None:
    html = comparison_section(finished, [replace(scored(psnr=math.nan), name="unscored")])
    assert '<th scope="row">unscored</th><td>preview</td><td>-</td>' in html
    assert "unscored: " not in html
