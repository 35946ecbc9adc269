"""`hgs edit`, on a scene that was never trained."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hgs_core.codec import load_manifest
from hgs_core.scene import load_scene
from server.cli import main


def test_options_are_done_in_order(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Trimmed; cropped in the world as it was; then turned upside down, made twice as large and moved."""
    out = tmp_path / "edited"
    options = ["--trim=0,0.1", "--sphere=0.2,0,0,1", "--up=0,1,0", "--scale=2", "--translate=5,0,0", "--json", "-"]
    capsys.readouterr()
    assert main(["edit", str(run), "--out", str(out), *options]) == 0
    told = capsys.readouterr()
    found = json.loads(told.out)
    assert (found["run"], found["splats"]) == (str(out), 153)
    assert "they are not inside of the sphere" in told.err
    manifest = load_manifest(out / "scene")
    assert (manifest.end, manifest.up) == (pytest.approx(0.1), (0.0, -1.0, 0.0))
    given = load_scene(run / "scene.npz").static.means
    kept = given[np.linalg.norm(given - np.float32([0.2, 0, 0]), axis=1) <= 1]
    turned = 2 * kept * [1, -1, -1] + [5, 0, 0]
    np.testing.assert_allclose(load_scene(out / "scene.npz").static.means, turned, atol=1e-5)


def test_an_edited_run_is_taken_like_any_other(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(tmp_path / "edited")
    assert main(["edit", str(run), "--out", out, "--drop-floaters", "--budget", "low"]) == 0
    size = load_manifest(tmp_path / "edited" / "scene").totals.bytes_static
    assert main(["encode", out, "--budget", "high"]) == 0
    assert load_manifest(tmp_path / "edited" / "scene").totals.bytes_static > size
    assert main(["export", out, "--to", str(tmp_path / "x.ply")]) == 0
    assert main(["publish", out]) == 0
    assert capsys.readouterr().out.endswith("edited\n")
    assert main(["eval", out]) == 2
    assert "was edited, so that no pictures show the scene as it is now" in capsys.readouterr().err


def test_listed_splats_go(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    chunk = load_manifest(run / "scene").static[0]
    listed = {"format": "hgs-splats", "version": 1, "chunks": {chunk.id: [[0, 2]]}}
    (tmp_path / "list.json").write_text(json.dumps(listed))
    assert main(["edit", str(run), "--out", str(tmp_path / "out"), "--splats", str(tmp_path / "list.json")]) == 0
    assert "3 of 145 splats left out: list.json lists them" in capsys.readouterr().err
    assert (
        len(load_scene(tmp_path / "out" / "scene.npz").static) == load_manifest(run / "scene").totals.splats_static - 3
    )


def test_two_runs_are_merged(run: Path, tmp_path: Path) -> None:
    assert main(["edit", str(run), "--out", str(tmp_path / "both"), "--merge", str(run), "--at=0.1"]) == 0
    manifest = load_manifest(tmp_path / "both" / "scene")
    assert manifest.end == pytest.approx(5 / 30 + 0.1)
    assert len(manifest.segments) == 3
    assert len(manifest.cameras) == 2 * len(load_manifest(run / "scene").cameras)


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        ([], "hgs edit: has nothing to do"),
        (["--inverse"], "--inverse: needs --box or --sphere"),
        (["--at=1"], "--at: needs --merge"),
        (["--trim=1"], "--trim: '1' are no finite numbers; give 2 of them"),
        (["--box=a,b"], "--box: 'a,b' are no finite numbers"),
        (["--box=0,0,0,1,1"], "--box: has 5 finite numbers"),
        (["--trim=0,9"], "--trim: 0 to 9 s is no stretch of the scene"),
        (["--splats=nowhere"], "nowhere: cannot be read (No such file or directory); give a list of splats"),
        (["--merge=nowhere"], "nowhere: is neither a finished run nor a scene folder"),
    ],
)
def test_bad_options_are_refused_in_one_line(
    run: Path, tmp_path: Path, refused: Callable[..., str], options: list[str], problem: str
) -> None:
    assert problem in refused("edit", run, "--out", tmp_path / "out", *options)
