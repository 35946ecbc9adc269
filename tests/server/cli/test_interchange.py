"""`hgs import`, `encode` and `export`, on a scene that was never trained."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from hgs_core.codec import decode_scene, load_manifest
from hgs_core.interchange import export_scene, import_scene
from hgs_core.scene import DynamicSplats, HybridScene, Segment
from hgs_core.scene.files import load_scene
from server.cli import main
from tests.synthetic import synthetic_scene, write_capture


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("capture")
    write_capture(path)
    return path


@pytest.fixture(scope="module")
def splats(capture: Path) -> Path:
    """An STGS file of the capture's scene, whose times 0 to 1 are five frames."""
    static, dynamic = synthetic_scene()
    scene = HybridScene(static, (Segment(0.0, 5 / 30, dynamic),)).map(lambda tensor: tensor.numpy())
    export_scene(scene, capture / "x.ply", cameras=[])
    return capture / "x.ply"


@pytest.fixture(scope="module")
def run(capture: Path, splats: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("runs") / "run"
    more = ["--capture", str(capture), "--hold-out", "2", "--duration", str(5 / 30)]
    assert main(["import", str(splats), "--out", str(out), *more]) == 0
    return out


def test_an_imported_run_is_scored_on_its_capture(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert main(["eval", str(run), "--json"]) == 0
    scores = json.loads(capsys.readouterr().out)
    assert scores["psnr"] > 30  # the scene is the capture's own
    assert scores["cameras"] == ["2"]
    assert load_manifest(run / "scene").antialiased is False


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
    assert coarseness.startswith("coarseness ")
    assert folder == str(run / "scene")


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


def test_the_float_scene_of_a_run_and_the_decoded_one_of_a_folder_are_exported(run: Path, tmp_path: Path) -> None:
    assert main(["export", str(run), "--to", str(tmp_path / "a.ply")]) == 0
    assert main(["export", str(run / "scene"), "--to", str(tmp_path / "b.ply"), "--time", "0.1"]) == 0
    exported = import_scene(tmp_path / "a.ply", 5 / 30).scene
    trained = load_scene(run / "scene.npz")
    np.testing.assert_array_equal(exported.static.means, trained.static.means)
    np.testing.assert_array_equal(exported.segments[0].dynamic.motion, trained.segments[0].dynamic.motion)
    moment = import_scene(tmp_path / "b.ply", 1.0).scene.static
    assert len(moment) >= len(decode_scene(run / "scene").static)


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["import", "x.ply", "--out", "run"], "x.ply: cannot be read"),
        (["import", "x.ply", "--out", "run", "--duration", "0"], "--duration: 0.0 is not positive"),
        (["export", "run", "--to", "x.ply"], "run: is neither a finished run nor a scene folder"),
        (["encode", "run"], "run: is not a run"),
    ],
)
def test_bad_input_is_one_line_and_status_2(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], arguments: list[str],
    problem: str,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    assert f"hgs: {problem}" in capsys.readouterr().err
    assert not any(tmp_path.iterdir())


def test_import_and_export_tell_what_they_left_out(
    splats: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
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
    target = tmp_path / "y.spz"
    assert main(["export", str(tmp_path / "run"), "--to", str(target), "--time", "0", "--json", "-"]) == 0
    told = capsys.readouterr()
    changes = {(change["action"], change["what"]): change for change in json.loads(told.out)["changes"]}
    assert changes[("rounded", "position")]["reason"] == "fixed point, steps of 1/4,096"
    assert f"{target}: rotation of " in told.err


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
