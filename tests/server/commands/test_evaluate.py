from __future__ import annotations

import json
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from hgs_core.progress import Progress, ProgressCallback
from hgs_core.run_folder import RunFolder
from server.cli import main
from server.commands.evaluate import FIELDS

SCORES: dict[str, Any] = {
    "psnr": 27.5,
    "ssim": 0.875,
    "bytes_total": 300,
    "bytes_static": 200,
    "bytes_dynamic": 90,
    "splats_static": 20,
    "splats_dynamic": 9,
    "train_seconds": 12.5,
    "frames": 60,
    "cameras": ["cam00"],
}


@pytest.fixture(autouse=True)
def scores(monkeypatch: pytest.MonkeyPatch) -> None:
    """Put an evaluation in the place of the real one that has these scores and one more."""

    def evaluate_run(run: Path, progress: ProgressCallback) -> dict[str, Any]:
        progress(Progress("evaluate", 1, 1))
        return {"lpips": 0.1, **SCORES}

    monkeypatch.setitem(sys.modules, "hgs_core.evaluate.run", SimpleNamespace(evaluate_run=evaluate_run))  # type: ignore[arg-type]
    monkeypatch.setattr(RunFolder, "read_spec", lambda self: None)


def test_json_is_one_object_of_exactly_the_documented_fields(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["eval", str(tmp_path), "--json"]) == 0
    output = json.loads(capsys.readouterr().out)
    assert output == SCORES
    assert tuple(output) == FIELDS


def test_text_names_every_field(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["eval", str(tmp_path)]) == 0
    lines = dict(line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    assert tuple(lines) == FIELDS
    assert (lines["psnr"], lines["cameras"]) == ("27.5000", "cam00")
