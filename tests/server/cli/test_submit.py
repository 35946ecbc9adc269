"""`hgs submit`, on the real queue."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.runs.run_folder import RunFolder
from jobs.queue.client import JobClient
from jobs.records.job import Job, JobState
from server.cli import main, submit
from tests.hgs_core.capture.sounding import write_sounding_video
from tests.server.cli.conftest import FRAMES


def test_submit_queues_a_job(n3dv: Path, home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["submit", str(n3dv), "--preset", "preview", "--title", "Three"]) == 0
    job_id = capsys.readouterr().out.strip()
    assert (home / "runs" / job_id / "run.json").is_file()


def test_a_submitted_run_keeps_its_masks(
    n3dv: Path, home: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "given" / "cam00"
    folder.mkdir(parents=True)
    for frame in range(FRAMES):
        Image.fromarray(np.full((48, 64), 255, np.uint8)).save(folder / f"{frame:04d}.png")
    assert main(["submit", str(n3dv), "--masks", str(folder.parent)]) == 0
    job_id = capsys.readouterr().out.strip()
    assert RunFolder(home / "runs" / job_id).read_spec().given.masks == folder.parent.resolve()


def test_a_submitted_run_keeps_its_depth_and_mesh(
    n3dv: Path, home: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "room.obj").write_text("")
    (tmp_path / "depth.json").write_text('{"scale": 0.001}')
    Image.fromarray(np.full((48, 64), 2500, np.uint16)).save(tmp_path / "cam00.png")
    assert main(["submit", str(n3dv), "--depth", str(tmp_path), "--mesh", str(tmp_path / "room.obj")]) == 0
    spec = RunFolder(home / "runs" / capsys.readouterr().out.strip()).read_spec()
    capture = spec.open_capture()
    assert capture.depth is not None
    assert (capture.depth.cameras, capture.mesh) == ([0], (tmp_path / "room.obj").resolve())
    Image.fromarray(np.zeros((48, 64), np.uint16)).save(tmp_path / "cam00.png")
    with pytest.raises(InputError, match="the capture has changed"):
        spec.open_capture()


def test_a_submitted_run_keeps_its_sound(
    n3dv: Path, home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write_sounding_video(tmp_path / "recorder.mkv", 5, np.zeros(8000))
    monkeypatch.chdir(tmp_path)
    assert main(["submit", str(n3dv), "--audio", "recorder.mkv"]) == 0
    job_id = capsys.readouterr().out.strip()
    assert RunFolder(home / "runs" / job_id).read_spec().given.audio == str((tmp_path / "recorder.mkv").resolve())
    assert main(["submit", str(n3dv), "--audio", "camera:cam00"]) == 2
    assert "its camera has no video with sound" in capsys.readouterr().err


@pytest.fixture
def ending(monkeypatch: pytest.MonkeyPatch, home: Path) -> Callable[[JobState, str], None]:
    """Return a function after which every job that is waited for trains a little and then ends in a state."""

    def prepare(state: JobState, error: str = "") -> None:
        whole = JobClient.get
        looks = iter(range(100))

        def get(client: JobClient, job_id: str) -> Job:
            job = whole(client, job_id)
            assert job is not None
            if next(looks) == 0:
                return replace(job, state=JobState.RUNNING, stage="train", done=3, total=9, figures={"psnr": 20.5})
            return replace(job, state=state, error=error)

        monkeypatch.setattr(JobClient, "get", get)
        monkeypatch.setattr(submit, "POLL_SECONDS", 0.0)

    return prepare


def test_waiting_follows_a_job_to_its_success(
    n3dv: Path, ending: Callable[..., None], capsys: pytest.CaptureFixture[str]
) -> None:
    ending(JobState.SUCCEEDED)
    assert main(["submit", str(n3dv), "--wait"]) == 0
    told = capsys.readouterr()
    assert len(told.out.split()) == 1  # the id
    for words in ("train", "3/9", "psnr=20.5"):
        assert words in told.err


@pytest.mark.parametrize(
    ("state", "error", "words"),
    [(JobState.FAILED, "out of memory", "failed: out of memory"), (JobState.CANCELLED, "", "cancelled")],
)
def test_a_job_that_does_not_succeed_says_so_in_its_exit_status(
    n3dv: Path, ending: Callable[..., None], capsys: pytest.CaptureFixture[str], state: JobState, error: str, words: str
) -> None:
    ending(state, error)
    assert main(["submit", str(n3dv), "--wait"]) == 1
    told = capsys.readouterr()
    assert told.err.splitlines()[-1] == f"hgs: job {told.out.strip()}: {words}"


def test_a_job_that_no_worker_takes_is_called_so(n3dv: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = "queued; no worker is running: start one with hgs worker, or hgs serve"
    assert main(["submit", str(n3dv)]) == 0
    told = capsys.readouterr()
    assert told.err.splitlines()[-1] == line
    assert len(told.out.split()) == 1
    assert main(["jobs", "ls"]) == 0
    assert capsys.readouterr().err == f"{line}\n"
