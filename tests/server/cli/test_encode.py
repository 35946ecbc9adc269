"""`hgs encode`, on a run that was imported."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from hgs_core.base.progress import silent
from hgs_core.codec import load_manifest
from hgs_core.decompose.masks import motion_masks
from hgs_core.runs.run_folder import RunFolder
from server.cli import main


def test_encode_tells_what_it_dropped_and_takes_the_place_of_the_scene(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = load_manifest(run / "scene").totals
    assert main(["encode", str(run), "--budget", "low"]) == 0
    static, dynamic, coarseness, folder = capsys.readouterr().out.splitlines()
    after = load_manifest(run / "scene").totals
    assert after.bytes_static < before.bytes_static
    assert static.startswith(f"{after.splats_static} static splats in {after.bytes_static:,} bytes")
    assert static.endswith(f"{150 - after.splats_static} dropped")
    assert dynamic.startswith(f"{after.splats_dynamic} dynamic splats in")
    assert re.fullmatch(r"coarseness [\d.e-]+, -?[\d.]+ dB lost in training views", coarseness)
    assert folder == str(run / "scene")


def test_encode_tells_what_is_lost_where_it_moves_if_there_are_masks(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = RunFolder(shutil.copytree(run, tmp_path / "run"))
    motion_masks(folder.read_spec().open_capture(), range(5), progress=silent).save(folder.masks, [0])
    assert main(["encode", str(folder.path)]) == 0
    line = capsys.readouterr().out.splitlines()[2]
    number = r"-?[\d.e-]+"
    assert re.fullmatch(
        rf"coarseness {number}(, {number} of dynamic splats)?, {number} dB lost in training views, "
        rf"{number} dB where it moves",
        line,
    )


@pytest.mark.usefixtures("small_views")
def test_encode_says_that_the_views_are_made_up_where_there_is_no_capture(
    splats: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = tmp_path / "run"
    assert main(["import", str(splats), "--out", str(run), "--duration", str(5 / 30)]) == 0
    capsys.readouterr()
    assert main(["encode", str(run)]) == 0
    assert capsys.readouterr().out.splitlines()[2].endswith(" dB lost in views made up around the splats")


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [([], "run: is not a run"), (["--fine-tune", "-1"], "--fine-tune: -1 is below 0")],
)
def test_bad_input_is_one_line_and_status_2(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    problem: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["encode", "run", *arguments]) == 2
    assert f"hgs: {problem}" in capsys.readouterr().err
    assert not any(tmp_path.iterdir())
