"""The stages on a tiny capture: each leaves its file, resumes, and refuses bad input before it writes."""

from __future__ import annotations

import dataclasses
import json
import re
import shutil
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, silent
from hgs_core.base.version import software_version
from hgs_core.capture.held_pictures import FrameSource, HeldPictures
from hgs_core.check.findings import CaptureCheck, Finding
from hgs_core.codec import decode_scene, load_manifest
from hgs_core.codec.encoder.find_captured_space import find_captured_space
from hgs_core.evaluate.run import evaluate_run
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder, RunSpec
from hgs_core.runs.stages import STAGES, create_run, train_scene
from hgs_core.scene.files import load_scene
from tests.conftest import REPOSITORY
from tests.synthetic import write_capture

CONFIG = RunConfig.from_json(
    {
        "capture": {"hold_out": ["2"]},
        "points": {"static": 300, "dynamic": 60, "interval": 0.1},
        "train": {
            "iterations": 60,
            "checkpoint_every": 20,
            "density": {"every": 20, "max_static": 400, "max_dynamic": 100},
        },
    }
)


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("capture")
    write_capture(path)
    return path


@pytest.fixture(scope="module")
def reported() -> dict[str, int]:
    """Stages that have reported progress, in order, and how often; filled by `finished`."""
    return {}


@pytest.fixture(scope="module")
def finished(capture: Path, tmp_path_factory: pytest.TempPathFactory, reported: dict[str, int]) -> Path:
    def report(progress: Progress) -> None:
        reported[progress.stage] = reported.get(progress.stage, 0) + 1

    run = tmp_path_factory.mktemp("runs") / "run"
    create_run(run, capture, CONFIG)
    for stage in STAGES.values():
        stage(run, report)
    return run


def test_a_run_ends_with_a_scene_that_decodes(finished: Path) -> None:
    scene, decoded = load_scene(finished / "scene.npz"), decode_scene(finished / "scene")
    manifest = load_manifest(finished / "scene" / "manifest.json")
    assert len(decoded.static) == manifest.totals.splats_static > 0
    assert len(decoded.static) <= len(scene.static)
    assert [camera.name for camera in manifest.cameras] == ["0", "1", "2", "3", "4"]
    assert manifest.training["iterations"] == 60


def test_the_manifest_tells_what_encoding_lost_and_what_where_it_moves(finished: Path) -> None:
    told = load_manifest(finished / "scene" / "manifest.json").training
    assert -1 < told["encoding_loss"] <= 0.1  # the default budget
    assert -1 < told["encoding_loss_moving"] <= 0.1


def test_a_training_leaves_a_picture_of_itself(finished: Path) -> None:
    with Image.open(finished / "preview.jpg") as preview, Image.open(finished / "scene" / "thumbnail.jpg") as thumbnail:
        assert preview.size == thumbnail.size


def test_the_captured_space_is_that_of_the_cameras_trained_on(finished: Path) -> None:
    manifest = load_manifest(finished / "scene" / "manifest.json")
    trained = [camera for camera in manifest.cameras if camera.name not in CONFIG.capture.hold_out]
    assert len(trained) == len(manifest.cameras) - 1
    assert manifest.captured_space is not None
    box = dataclasses.replace(manifest.captured_space, seen=None)
    assert box == find_captured_space(trained, manifest.center, manifest.up)
    assert box != find_captured_space(manifest.cameras, manifest.center, manifest.up)


def test_the_captured_space_is_limited_to_views_that_hold_every_camera_trained_on(finished: Path) -> None:
    manifest = load_manifest(finished / "scene" / "manifest.json")
    space = manifest.captured_space
    assert space is not None
    assert space.seen is not None
    trained = [camera for camera in manifest.cameras if camera.name not in CONFIG.capture.hold_out]
    assert all(space.holds(space.place(camera.position, manifest.center, manifest.up)) for camera in trained)


def test_progress_is_reported_under_the_names_of_the_protocol(finished: Path, reported: dict[str, int]) -> None:
    table = (REPOSITORY / "docs" / "rest.md").read_text().partition("| stage, in order |")[2].partition("\n\n")[0]
    documented = re.findall(r"^\| `(\w+)` \|", table, re.MULTILINE)
    of_jobs, of_what_is_missing = ("initialise", "publish"), ("sync", "cameras")
    assert list(reported) == [name for name in documented if name not in of_jobs + of_what_is_missing]


def test_finished_stages_do_nothing(finished: Path) -> None:
    before = {path: path.stat().st_mtime_ns for path in finished.rglob("*") if path.is_file()}

    def refuse(progress: Progress) -> None:
        raise AssertionError(progress)

    for stage in STAGES.values():
        stage(finished, refuse)
    assert before == {path: path.stat().st_mtime_ns for path in finished.rglob("*") if path.is_file()}


def test_evaluation_has_exactly_its_fields_and_counts_every_byte(finished: Path) -> None:
    result = evaluate_run(finished, silent)
    assert set(result) == {
        "psnr",
        "ssim",
        "ms_ssim",
        "lpips",
        "flip",
        "flicker",
        "flicker_steady",
        "psnr_dynamic",
        "psnr_static",
        "ssim_dynamic",
        "lpips_dynamic",
        "psnr_dynamic_colour_corrected",
        "psnr_colour_corrected",
        "psnr_lens_corrected",
        "psnr_dynamic_lens_corrected",
        "psnr_rig",
        "ssim_rig",
        "lpips_rig",
        "psnr_dynamic_rig",
        "ssim_dynamic_rig",
        "lpips_dynamic_rig",
        "lpips_network",
        "lens_falloff",
        "colour_map",
        "magnified",
        "bytes_total",
        "bytes_static",
        "bytes_dynamic",
        "splats_static",
        "splats_dynamic",
        "train_seconds",
        "frames",
        "cameras",
        "cameras_trained_on",
        "truth",
        "masks",
        "per_camera",
        "per_frame",
    }
    chunks = sum(path.stat().st_size for path in (finished / "scene" / "chunks").iterdir())
    assert result["bytes_static"] + result["bytes_dynamic"] == chunks
    assert result["bytes_total"] == chunks + (finished / "scene" / "manifest.json").stat().st_size
    assert result["cameras"] == ["2"]
    assert result["frames"] == 6
    assert result["psnr"] > 10
    assert json.loads((finished / "eval.json").read_text()) == result


def test_a_run_is_published_and_scored_as_antialiased_as_it_was_trained(finished: Path, tmp_path: Path) -> None:
    run = tmp_path / "run"
    shutil.copytree(finished, run)
    spec = json.loads((run / "run.json").read_text())
    spec["config"]["train"]["antialiased"] = False
    (run / "run.json").write_text(json.dumps(spec))
    shutil.rmtree(run / "scene")
    STAGES["encode"](run, silent)
    assert not load_manifest(run / "scene").antialiased
    assert load_manifest(finished / "scene").antialiased
    assert (run / "scene" / "thumbnail.jpg").read_bytes() != (finished / "scene" / "thumbnail.jpg").read_bytes()
    assert evaluate_run(run, silent)["psnr"] != evaluate_run(finished, silent)["psnr"]


@pytest.fixture
def faulty(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Have every capture checked as faulty; the list has an entry per check."""
    found = CaptureCheck((), (Finding(True, ("1",), "it is upside down", "turn it"),), (), (0,), 64)
    calls: list[int] = []

    def check(capture: object, progress: object) -> CaptureCheck:
        calls.append(1)
        return found

    monkeypatch.setattr("hgs_core.check.capture_check.check_capture", check)
    return calls


@pytest.mark.parametrize("stage", ["check", "initialise"])
def test_a_faulty_capture_stops_the_run_until_its_poses_are_trusted(
    tmp_path: Path, capture: Path, faulty: list[int], stage: str
) -> None:
    run = tmp_path / "run"
    create_run(run, capture, CONFIG)
    for _ in range(2):
        with pytest.raises(InputError, match=r"camera 1: it is upside down; turn it; or train with --trust-poses"):
            STAGES[stage](run, silent)
    assert faulty == [1], "the result is kept"
    create_run(run, capture, CONFIG.changed({"capture.trust_poses": True}))
    STAGES["check"](run, silent)
    create_run(run, capture, CONFIG)  # trusted no longer
    with pytest.raises(InputError):
        STAGES["check"](run, silent)


def test_what_the_check_found_is_told_also_where_it_stops_the_run(
    tmp_path: Path, capture: Path, faulty: list[int]
) -> None:
    told: list[CaptureCheck] = []
    with pytest.raises(InputError):
        train_scene(capture, tmp_path / "run", CONFIG, checked=told.append)
    assert [finding.problem for finding in told[0].findings] == ["it is upside down"]
    assert faulty == [1]


def test_every_picture_is_decoded_once(tmp_path: Path, capture: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    reads: Counter[tuple[int, int]] = Counter()

    class Counting(HeldPictures):
        def __init__(self, source: FrameSource, *arguments: Any) -> None:
            super().__init__(source, *arguments)
            read = source.read
            source.read = lambda camera, frame, more: reads.update([(camera, frame)]) or read(camera, frame, more)

    monkeypatch.setattr("hgs_core.capture.capture.HeldPictures", Counting)
    train_scene(capture, tmp_path / "run", CONFIG.changed({"train.iterations": 4, "encode.fine_tune": 0.0}))
    assert set(reads.values()) == {1}


def test_a_capture_that_changed_is_noticed(tmp_path: Path) -> None:
    write_capture(tmp_path / "capture", frames=2)
    create_run(tmp_path / "run", tmp_path / "capture", CONFIG)
    meta = tmp_path / "capture" / "train_meta.json"
    value = json.loads(meta.read_text())
    value["k"] = (np.array(value["k"]) * 1.01).tolist()
    meta.write_text(json.dumps(value))
    with pytest.raises(InputError, match="has changed"):
        STAGES["initialise"](tmp_path / "run", silent)


def test_photographs_of_one_moment_end_without_anything_dynamic(tmp_path: Path) -> None:
    """The same pictures as transforms.json: nothing tells the stages that the scene is still."""
    views = write_capture(tmp_path / "ims", frames=1)
    flip = np.diag([1.0, -1.0, -1.0, 1.0])
    frames = [
        {
            "file_path": f"ims/ims/{view.name}/000000.jpg",
            "transform_matrix": (np.linalg.inv(view.world_to_camera) @ flip).tolist(),
        }
        for view in views
    ]
    intrinsics = {"fl_x": views[0].fx, "fl_y": views[0].fy, "cx": views[0].cx, "cy": views[0].cy}
    (tmp_path / "transforms.json").write_text(json.dumps({**intrinsics, "k1": 0.01, "frames": frames}))
    config = CONFIG.changed({"capture.hold_out": ["ims/ims/2/000000"]})
    create_run(tmp_path / "run", tmp_path, config)
    for stage in STAGES.values():
        stage(tmp_path / "run", silent)
    manifest = load_manifest(tmp_path / "run" / "scene" / "manifest.json")
    assert manifest.totals.splats_static > 0
    assert manifest.totals.splats_dynamic == manifest.totals.bytes_dynamic == 0
    assert evaluate_run(tmp_path / "run", silent)["frames"] == 1


def test_evaluating_an_unfinished_run_says_how_to_finish_it(capture: Path, tmp_path: Path) -> None:
    create_run(tmp_path / "run", capture, CONFIG)
    with pytest.raises(InputError, match="finish it with hgs train"):
        evaluate_run(tmp_path / "run", silent)
    with pytest.raises(InputError, match=r"no run\.json"):
        evaluate_run(tmp_path, silent)


def test_a_run_folder_survives_a_damaged_spec(tmp_path: Path) -> None:
    (tmp_path / "run.json").write_text("{")
    with pytest.raises(InputError, match=r"run\.json"):
        RunFolder(tmp_path).read_spec()


def test_two_processes_never_work_on_one_run(tmp_path: Path) -> None:
    with (
        RunFolder(tmp_path).exclusive(),
        pytest.raises(InputError, match="another process works on this run"),
        RunFolder(tmp_path).exclusive(patience=0.2),
    ):
        pass
    with RunFolder(tmp_path).exclusive():
        pass


def test_machine_and_curves_are_kept_beside_the_run_and_not_published(finished: Path) -> None:
    recorded = json.loads((finished / "train.json").read_text())
    assert recorded["machine"]["hgs"] == software_version()
    assert recorded["machine"]["cores"] >= 1
    assert recorded["history"]["psnr"]
    published = load_manifest(finished / "scene" / "manifest.json").training
    assert not {"machine", "history", "profile"} & set(published)
    assert published["iterations"] == recorded["iterations"]


def test_a_job_that_initialises_prepares_the_capture_first(
    capture: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Jobs have no stage of their own for it: those of earlier versions go on."""

    def refuse(spec: RunSpec, own: Path, progress: object) -> None:
        raise InputError(spec.capture, "has no poses", "find them")

    monkeypatch.setattr("hgs_core.runs.preparation.prepared_capture", refuse)
    folder = RunFolder(tmp_path / "run")
    folder.write_spec(RunSpec(capture, "", CONFIG, prepared=False))
    with pytest.raises(InputError, match="has no poses"):
        STAGES["initialise"](folder.path, silent)
