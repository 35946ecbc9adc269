"""The preparation of a capture: on small videos, with the true poses in place of the search."""

from __future__ import annotations

import json
import logging
import shutil
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, silent
from hgs_core.calibrate.colmap_text import write_colmap_text
from hgs_core.calibrate.structure import Solution, SolvedCamera
from hgs_core.check.starts import Starts
from hgs_core.runs import preparation
from hgs_core.runs.creation import create_run, prepare
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from hgs_core.scene.camera import looking_at
from tests.hgs_core.capture.sounding import write_sounding_video
from tests.hgs_core.check.test_starts_by_sound import heard, scene

NAMES = ("a", "b", "c", "d", "e", "f")
CONFIG = RunConfig()


@pytest.fixture(scope="module")
def videos(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six videos of which the third began half a second after the others, as their sound says."""
    folder, sound = tmp_path_factory.mktemp("videos"), 0.2 * scene(5)
    for name in NAMES:
        write_sounding_video(folder / f"{name}.mkv", 20, heard(sound, 0.5 if name == "c" else 0.0))
    return folder


@pytest.fixture
def folder(videos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a copy of the videos; the search for poses finds them on an arc, and reports as the real one."""

    def find(folder: Path, *, found: Path | None, progress: object) -> None:
        progress(Progress("features", 3, 6))  # type: ignore[operator]
        progress(Progress("matches", 6, 6))  # type: ignore[operator]
        for done in (1, 2, 1):
            progress(Progress("mapping", done, 2))  # type: ignore[operator]
        cameras = []
        for number, name in enumerate(NAMES):
            pose = looking_at([np.sin(0.2 * number), 0.0, -np.cos(0.2 * number)], [0.0, 0.0, 0.0])
            cameras.append(SolvedCamera(name, 32, 32, "SIMPLE_RADIAL", (40.0, 16.0, 16.0, 0.0), pose, 50))
        write_colmap_text((found or folder) / "sparse" / "0", Solution(tuple(cameras), np.zeros((0, 3)), 0.1))

    monkeypatch.setattr(preparation, "find_cameras", find)
    return Path(shutil.copytree(videos, tmp_path / "capture"))


def test_poses_and_starts_are_found_and_kept_beside_the_videos(
    folder: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.WARNING)
    run = RunFolder(tmp_path / "run")
    assert create_run(run.path, folder, CONFIG).capture.hold_out == ()
    assert not run.read_spec().prepared
    with pytest.raises(InputError, match="has not found its cameras yet"):
        run.read_spec().open_capture()
    reported: list[Progress] = []
    prepare(run.path, reported.append)
    assert json.loads((folder / "sync.json").read_text())["seconds"]["c"] == pytest.approx(0.5, abs=2e-4)
    assert (folder / "sparse" / "0" / "cameras.txt").is_file()
    assert f"written to {folder / 'sync.json'}" in caplog.text
    assert f"written to {folder / 'sparse' / '0'}" in caplog.text
    cameras = [(one.done, one.total) for one in reported if one.stage == "cameras"]
    assert cameras == [(50, 300), (200, 300), (250, 300), (300, 300), (300, 300)]
    spec = run.read_spec()
    assert spec.prepared
    assert len(spec.open_capture().times) == 5  # 20 frames, 15 of which another camera does not have
    prepare(run.path, lambda progress: pytest.fail("it was prepared"))
    create_run(run.path, folder, CONFIG)  # resumes
    assert run.read_spec() == spec


def test_the_camera_to_hold_out_is_chosen_when_poses_are_known(folder: Path, tmp_path: Path) -> None:
    config = CONFIG.changed({"capture.hold_out": ["auto"], "capture.sync": "none"})
    run = RunFolder(tmp_path / "run")
    create_run(run.path, folder, config)
    prepare(run.path, silent)
    (name,) = run.read_spec().config.capture.hold_out
    assert name in NAMES
    assert not (folder / "sync.json").exists()
    assert create_run(run.path, folder, config).capture.hold_out == (name,)


def test_what_is_found_stays_in_the_run_where_the_capture_cannot_be_written(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def refuse(place: Path) -> None:
        if place == folder:
            raise InputError(place, "cannot be written")

    monkeypatch.setattr(preparation, "require_writable_folder", refuse)
    before = sorted(folder.rglob("*"))
    run = RunFolder(tmp_path / "run")
    create_run(run.path, folder, CONFIG)
    prepare(run.path, silent)
    assert sorted(folder.rglob("*")) == before
    assert (run.found / "sync.json").is_file()
    assert len(run.read_spec().open_capture().times) == 5
    assert "cannot be written to" in caplog.text
    create_run(run.path, folder, CONFIG)  # resumes
    assert len(run.read_spec().open_capture().cameras) == len(NAMES)


def test_nothing_is_said_of_a_folder_in_which_nothing_is_to_be_written(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    first, second = RunFolder(tmp_path / "first"), RunFolder(tmp_path / "second")
    create_run(first.path, folder, CONFIG)
    prepare(first.path, silent)
    (folder / "sync.json").unlink()
    shutil.copy(folder / "a.mkv", folder / "c.mkv")  # all in step
    caplog.clear()
    monkeypatch.setattr(preparation, "require_writable_folder", lambda place: pytest.fail(f"{place} was tried"))
    create_run(second.path, folder, CONFIG)
    prepare(second.path, silent)
    assert second.read_spec().prepared
    assert "written" not in caplog.text


def test_what_is_found_stays_in_the_run_where_that_has_a_folder_for_it(folder: Path, tmp_path: Path) -> None:
    before = sorted(folder.rglob("*"))
    run = RunFolder(tmp_path / "run")
    create_run(run.path, folder, CONFIG)
    run.found.mkdir()
    prepare(run.path, silent)
    assert sorted(folder.rglob("*")) == before
    assert (run.found / "sync.json").is_file()
    assert len(run.read_spec().open_capture().times) == 5


def test_a_way_that_was_asked_for_must_tell(folder: Path, tmp_path: Path) -> None:
    create_run(tmp_path / "run", folder, CONFIG.changed({"capture.sync": "motion"}))
    with pytest.raises(InputError, match="does not tell when the cameras began"):
        prepare(tmp_path / "run", silent)
    assert not (folder / "sync.json").exists()


def test_a_capture_that_says_when_its_cameras_began_is_left_as_it_is(folder: Path, tmp_path: Path) -> None:
    (folder / "sync.json").write_text('{"frames": {"c": 2}}')
    create_run(tmp_path / "run", folder, CONFIG)
    prepare(tmp_path / "run", silent)
    assert (folder / "sync.json").read_text() == '{"frames": {"c": 2}}'
    assert len(RunFolder(tmp_path / "run").read_spec().open_capture().times) == 18


def test_two_videos_without_poses_are_refused_at_once(folder: Path, tmp_path: Path) -> None:
    for name in NAMES[2:]:
        (folder / f"{name}.mkv").unlink()
    with pytest.raises(InputError, match="no file of the cameras' poses"):
        create_run(tmp_path / "run", folder, CONFIG)
    assert not (tmp_path / "run").exists()


def test_a_sound_that_does_not_tell_of_every_camera_is_said(
    folder: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.WARNING)
    write_sounding_video(folder / "c.mkv", 20, None)
    create_run(tmp_path / "run", folder, CONFIG)
    prepare(tmp_path / "run", silent)
    assert "there is no sound track in the video of c; what moves is asked" in caplog.text
    assert not (folder / "sync.json").exists()


def test_videos_that_nothing_puts_in_step_are_taken_to_be_so_and_that_is_said(
    folder: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    for seed, name in enumerate(NAMES):
        write_sounding_video(folder / f"{name}.mkv", 30, None, seed=seed)
    create_run(tmp_path / "run", folder, CONFIG)
    prepare(tmp_path / "run", silent)
    assert "nothing tells whether the videos are in step" in caplog.text
    assert "no sound track" not in caplog.text


def test_starts_that_poses_do_not_make_finer_are_kept_and_that_is_said(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    create_run(tmp_path / "first", folder, CONFIG.changed({"capture.sync": "none"}))
    prepare(tmp_path / "first", silent)  # finds the poses alone

    def too_little(*_: object) -> Starts:
        raise InputError(folder, "too little that moves is seen by c")

    rough = Starts("motion", "frames", {name: 5.0 * (name == "c") for name in NAMES})
    monkeypatch.setattr(preparation, "has_sound", lambda _: False)
    monkeypatch.setattr(preparation, "starts_by_energy", lambda *_: rough)
    monkeypatch.setattr(preparation, "starts_by_motion", too_little)
    create_run(tmp_path / "run", folder, CONFIG)
    prepare(tmp_path / "run", silent)
    assert "too little that moves is seen by c; the cameras are in step to about half a frame" in caplog.text
    assert json.loads((folder / "sync.json").read_text())["frames"]["c"] == 5
