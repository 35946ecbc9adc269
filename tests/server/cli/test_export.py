"""`hgs export`, of a run that was imported."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from hgs_core.codec import decode_scene
from hgs_core.interchange import import_scene
from hgs_core.scene.files import load_scene
from server.cli import main


def test_the_float_scene_of_a_run_and_the_decoded_one_of_a_folder_are_exported(run: Path, tmp_path: Path) -> None:
    assert main(["export", str(run), "--to", str(tmp_path / "a.ply")]) == 0
    assert main(["export", str(run / "scene"), "--to", str(tmp_path / "b.ply"), "--time", "0.1"]) == 0
    exported = import_scene(tmp_path / "a.ply", 5 / 30).scene
    trained = load_scene(run / "scene.npz")
    np.testing.assert_array_equal(exported.static.means, trained.static.means)
    np.testing.assert_array_equal(exported.segments[0].dynamic.motion, trained.segments[0].dynamic.motion)
    moment = import_scene(tmp_path / "b.ply", 1.0).scene.static
    assert len(moment) >= len(decode_scene(run / "scene").static)


def test_it_tells_what_the_file_cannot_hold(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "y.spz"
    assert main(["export", str(run), "--to", str(target), "--time", "0", "--json", "-"]) == 0
    told = capsys.readouterr()
    changes = {(change["action"], change["what"]): change for change in json.loads(told.out)["changes"]}
    assert changes[("rounded", "position")]["reason"] == "fixed point, steps of 1/4,096"
    assert f"{target}: rotation of " in told.err


def test_a_folder_that_is_neither_run_nor_scene_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["export", "run", "--to", "x.ply"]) == 2
    assert "hgs: run: is neither a finished run nor a scene folder" in capsys.readouterr().err
    assert not any(tmp_path.iterdir())
