"""Runs as a report reads them, damaged ones among them."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.progress import silent
from hgs_core.report.sources import FinishedRun, finite_number, read_run
from tests.hgs_core.report.finished_run import HISTORY, write_finished_run


def test_an_unmeasured_run_is_measured_first(run: Path) -> None:
    path = write_finished_run(run.parent, "unmeasured")
    assert not (path / "eval.json").exists()
    found = read_run(path, silent)
    assert found.score("psnr") == json.loads((path / "eval.json").read_text())["psnr"]


@pytest.fixture
def copied(run: Path, tmp_path: Path) -> Path:
    """A measured run that may be damaged."""
    return shutil.copytree(run, tmp_path / "run")


@pytest.mark.parametrize("file", ["train.json", "scene/manifest.json"])
def test_an_unfinished_run_is_refused_with_the_way_on(copied: Path, file: str) -> None:
    (copied / file).unlink()
    with pytest.raises(InputError, match="no encoded scene yet; finish it with hgs train"):
        read_run(copied, silent)


@pytest.mark.parametrize("text", ["{", "[]", "\ufffd"])
@pytest.mark.parametrize("file", ["eval.json", "train.json"])
def test_a_damaged_file_is_refused_by_name(copied: Path, file: str, text: str) -> None:
    (copied / file).write_text(text)
    with pytest.raises(InputError, match=file.replace(".", r"\.") + ": (unreadable|is not a JSON object)"):
        read_run(copied, silent)


def test_a_training_without_its_seconds_is_refused(copied: Path) -> None:
    (copied / "train.json").write_text('{"iterations": 40}')
    with pytest.raises(InputError, match="lacks the seconds or the iterations of training"):
        read_run(copied, silent)


def with_summary(run: Path, **summary: Any) -> FinishedRun:
    (run / "train.json").write_text(json.dumps({"seconds": 12.0, "iterations": 40, **summary}))
    return read_run(run, silent)


def test_figures_of_another_length_are_left_out_of_the_history(copied: Path) -> None:
    history = with_summary(copied, history={**HISTORY, "loss": [0.4, 0.2], "psnr": [1.0, None, "x", 4.0]}).history
    assert history is not None
    assert "loss" not in history.figures
    assert history.seconds == HISTORY["seconds"]
    assert [value if math.isfinite(value) else None for value in history.figures["psnr"]] == [1.0, None, None, 4.0]


@pytest.mark.parametrize("history", [None, [], {"iteration": [1.0], "loss": [2.0]}, {"iteration": [1.0, 2.0]}])
def test_a_history_of_nothing_is_none(copied: Path, history: Any) -> None:
    assert with_summary(copied, history=history).history is None


def test_activities_without_time_are_left_out(copied: Path) -> None:
    found = with_summary(copied, profile={"frames": 3.0, "Adam": 0.0, "x": "much"}, machine=[])
    assert (found.profile, found.machine) == ({"frames": 3.0}, {})


def test_bytes_are_counted_as_eval_json_counts_them(copied: Path) -> None:
    assert read_run(copied, silent).bytes_total == json.loads((copied / "eval.json").read_text())["bytes_total"]


@pytest.mark.parametrize(("value", "number"), [(1, 1.0), (2.5, 2.5), (True, None), ("3", None), (math.inf, None)])
def test_only_finite_numbers_are_numbers(value: Any, number: float | None) -> None:
    assert finite_number(value) == number
