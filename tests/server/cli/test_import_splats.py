"""`hgs import`, on a scene that was never trained."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from hgs_core.codec import load_manifest
from hgs_core.interchange import export_scene, import_scene
from hgs_core.interchange.ply.ply_table import write_ply
from hgs_core.scene import DynamicSplats, HybridScene, Segment
from server.cli import main

pytestmark = pytest.mark.usefixtures("small_views")


def test_an_imported_run_is_scored_on_its_capture(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert main(["eval", str(run), "--json"]) == 0
    scores = json.loads(capsys.readouterr().out)
    assert scores["psnr"] > 30  # the scene is the capture's own
    assert scores["cameras"] == ["2"]
    assert load_manifest(run / "scene").antialiased is False


def test_without_a_capture_a_run_can_be_encoded_but_not_scored(
    splats: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = tmp_path / "run"
    assert main(["import", str(splats), "--out", str(run), "--duration", "0.1"]) == 0
    manifest = load_manifest(run / "scene")
    assert (manifest.cameras[0].name, manifest.end) == ("front", pytest.approx(0.1))
    assert main(["encode", str(run), "--budget", "low"]) == 0
    assert load_manifest(run / "scene").totals.bytes_static < manifest.totals.bytes_static
    capsys.readouterr()
    assert main(["eval", str(run)]) == 2
    assert "was imported without a capture; import it again with --capture" in capsys.readouterr().err


def test_an_import_of_which_nothing_shows_leaves_no_run(
    splats: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Two faint points far apart: they can be seen, but no picture misses them."""
    given = import_scene(splats, 0.1).scene.static.take(slice(0, 2))
    given.opacity_logits[:] = -4.8
    given.log_scales[:] = -20
    still = HybridScene(given, (Segment(0.0, 0.0, DynamicSplats.empty()),))
    export_scene(still, tmp_path / "x.ply", cameras=[])
    assert main(["import", str(tmp_path / "x.ply"), "--out", str(tmp_path / "run")]) == 2
    assert "x.ply: holds 2 splats, none of which shows in any picture" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


def test_cameras_cannot_be_held_out_without_a_capture(
    splats: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["import", str(splats), "--out", str(tmp_path / "run"), "--hold-out", "2"]) == 2
    assert "--hold-out: needs the capture's cameras" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("more", "problem"),
    [
        ([], "x.ply: cannot be read"),
        (["--duration", "0"], "--duration: 0.0 is not positive"),
        (["--fps", "30"], "--fps: is for a folder of frames; give --duration"),
    ],
)
def test_bad_input_is_one_line_and_leaves_no_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], more: list[str], problem: str
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["import", "x.ply", "--out", "run", *more]) == 2
    assert f"hgs: {problem}" in capsys.readouterr().err
    assert not any(tmp_path.iterdir())


def test_it_tells_what_it_left_out(splats: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = import_scene(splats, 0.1).scene
    given.static.means[:3] = np.nan
    given.static.opacity_logits[3:5] = -6  # below 1/255
    export_scene(given, tmp_path / "x.ply", cameras=[])
    capsys.readouterr()
    arguments = ["import", str(tmp_path / "x.ply"), "--out", str(tmp_path / "run"), "--duration", "0.03"]
    assert main([*arguments, "--json", "-"]) == 0
    told = capsys.readouterr()
    found = json.loads(told.out)
    before, kept = found["splats"], found["kept"]
    totals = load_manifest(tmp_path / "run" / "scene").totals
    assert (before, kept) == (153, totals.splats_static + totals.splats_dynamic)
    assert [(c["action"], c["count"], c["of"], c["reason"]) for c in found["changes"]] == [
        ("left out", 3, 153, "position is no finite number"),
        ("left out", 150 - kept, 150, "no picture misses them"),
    ]
    assert 150 - kept >= 2
    assert f"x.ply: {150 - kept} of 150 splats left out: no picture misses them" in told.err


def test_splats_that_were_trained_antialiased_are_drawn_so(splats: Path, tmp_path: Path) -> None:
    out = tmp_path / "run"
    assert main(["import", str(splats), "--out", str(out), "--duration", "0.03", "--antialiased"]) == 0
    assert load_manifest(out / "scene").antialiased is True


def test_pictures_of_a_capture_are_asked_how_a_file_is_drawn_that_does_not_say(
    capture: Path, splats: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Splats of many pixels look the same both ways: the usual choice is kept, with a report of the figures."""
    (tmp_path / "x.ply").write_bytes(splats.read_bytes().replace(b"comment hgs_antialiased 0\n", b""))
    capsys.readouterr()
    arguments = ["import", str(tmp_path / "x.ply"), "--out", str(tmp_path / "run"), "--duration", str(5 / 30)]
    assert main([*arguments, "--capture", str(capture), "--hold-out", "2"]) == 0
    told = capsys.readouterr().err
    assert "drawing without antialiasing assumed: the capture's pictures are " in told
    assert "dB with antialiasing" in told
    assert load_manifest(tmp_path / "run" / "scene").antialiased is False


def test_an_ambiguous_file_is_refused_with_the_options_that_settle_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rng = np.random.default_rng(0)
    names = ("x", "y", "z", "scale_0", "scale_1", "scale_2", "rot_1", "rot_2", "rot_3", "f_dc_0", "f_dc_1", "f_dc_2")
    table = {name: rng.normal(-2, 0.5, 60) for name in names}
    table |= {"rot_0": np.ones(60), "opacity": np.full(60, 0.9)}
    (tmp_path / "x.ply").write_bytes(write_ply(table))
    arguments = ["import", str(tmp_path / "x.ply"), "--out", str(tmp_path / "run")]
    assert main(arguments) == 2
    assert "--activated if so, with --no-activated if" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()
    assert main([*arguments, "--no-activated", "--no-antialiased"]) == 0
    assert "assumed" not in capsys.readouterr().err


def test_frames_that_were_exported_play_again(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    frames, back = tmp_path / "frames", tmp_path / "back"
    assert main(["export", str(run), "--to", str(frames), "--fps", "20"]) == 0
    count = len(list(frames.iterdir()))
    assert main(["import", str(frames), "--out", str(back), "--fps", "20"]) == 0
    manifest = load_manifest(back / "scene")
    assert len(manifest.segments) == count > 2
    assert manifest.end == pytest.approx(count / 20)
    assert "export" in capsys.readouterr().err  # the bar
    for option, value in (("--duration", "2"), ("--fps", "0")):
        assert main(["import", str(frames), "--out", str(tmp_path / "no"), option, value]) == 2
        assert f"hgs: {option}: " in capsys.readouterr().err
