"""A report of the remains of a run, and the refusals before one is written."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.progress import silent
from hgs_core.check.findings import CameraResult, CaptureCheck, Finding, ShownMatch, ShownPair
from hgs_core.report.write import write_report


def written(run: Path, out: Path, *against: Path) -> str:
    write_report(run, out, against, silent)
    return out.read_text()


def tile(text: str, key: str) -> str:
    found = re.search(rf'data-figure="{key}">.*?class="value">([^<]*)<', text)
    assert found, key
    return found[1]


def test_without_the_capture_the_page_says_so_and_has_no_pictures(run: Path, tmp_path: Path) -> None:
    shutil.copytree(run, tmp_path / "run")
    spec = json.loads((run / "run.json").read_text())
    (tmp_path / "run" / "run.json").write_text(json.dumps(spec | {"capture": str(tmp_path / "gone")}))
    text = written(tmp_path / "run", tmp_path / "report.html")
    assert "<img" not in text
    assert "No pictures" in text
    assert "the folder does not exist" in text
    assert tile(text, "psnr") == f"{json.loads((run / 'eval.json').read_text())['psnr']:.2f}"


def test_the_check_of_the_capture_is_drawn(run: Path, tmp_path: Path) -> None:
    shutil.copytree(run, tmp_path / "run")
    match = ShownMatch((10.0, 20.0), (30.0, 34.0), (0.0, 1.0, -30.0))
    pair = ShownPair(("0", "1"), 3, ((64, 48), (64, 48)), 5.5, (match,))
    results = (CameraResult("0", 1, 40, 5.5, None), CameraResult("1", 1, 40, 5.5, None))
    CaptureCheck(results, (Finding(True, ("1",), "it is upside down", "turn it"),), (pair,), (0, 3), 64).save(
        tmp_path / "run" / "check.json"
    )
    text = written(tmp_path / "run", tmp_path / "report.html")
    assert "1: it is upside down; turn it" in text
    assert len(re.findall(r'<image href="data:image/jpeg;base64,/9j', text)) == 2


def test_a_run_without_capture_and_scores_still_tells_its_size(run: Path, tmp_path: Path) -> None:
    shutil.copytree(run, tmp_path / "run")
    (tmp_path / "run" / "eval.json").unlink()
    spec = json.loads((run / "run.json").read_text())
    (tmp_path / "run" / "run.json").write_text(json.dumps(spec | {"capture": str(tmp_path / "gone")}))
    text = written(tmp_path / "run", tmp_path / "report.html")
    assert "No scores" in text
    assert 'data-figure="psnr"' not in text
    assert float(tile(text, "bytes_total")) > 0


def test_a_folder_as_the_page_is_refused(run: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is a folder"):
        written(run, tmp_path)


def test_an_unfinished_run_leaves_no_page(run: Path, tmp_path: Path) -> None:
    shutil.copytree(run, tmp_path / "run")
    (tmp_path / "run" / "train.json").unlink()
    with pytest.raises(InputError, match="no encoded scene yet"):
        written(tmp_path / "run", tmp_path / "report.html")
    assert not (tmp_path / "report.html").exists()
