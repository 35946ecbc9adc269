from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from jobs.home.home import Home
from jobs.process import stage_sandbox
from jobs.process.landlock import landlock_version
from jobs.process.sandbox import missing_from_sandbox
from jobs.process.stage_sandbox import missing_from_stages

needs_sandbox = pytest.mark.skipif(landlock_version() < 6, reason=missing_from_sandbox() or "the kernel has it all")


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """Return a run folder with a capture and given files, beside files of others."""
    for name in ("capture", "masks", "run", "others", "tmp"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "file").write_text("text")
    for name in ("mesh.ply", "sound.wav"):
        (tmp_path / name).write_text("text")
    spec = {"capture": "capture", "masks": "masks", "mesh": "mesh.ply", "audio": "sound.wav"}
    (tmp_path / "run" / "run.json").write_text(json.dumps({name: str(tmp_path / one) for name, one in spec.items()}))
    return tmp_path / "run"


def read_and_written(home: Home, stage: str, run: Path, before: str = "") -> tuple[list[str], list[str]]:
    """Return the places beside a run that a process in its stage's sandbox can read, and those that it can write."""
    program = f"""
import json, sys
from pathlib import Path
from jobs.home.home import Home
from jobs.process import stage_sandbox
{before}
places = sorted(Path({str(run.parent)!r}).iterdir())
stage_sandbox.enter_stage_sandbox(Home.from_environment(), {stage!r}, Path({str(run)!r}))
read, written = [], []
for place in places:
    if place.name == "home":
        continue
    file = place / "file" if place.is_dir() else place
    for found, mode in ((read, "r"), (written, "a")):
        try:
            file.open(mode).close()
            found.append(place.name)
        except PermissionError:
            pass
print(json.dumps([read, written]))
"""
    environment = {**os.environ, **home.environment(), "TMPDIR": str(run.parent / "tmp")}
    read, written = json.loads(subprocess.check_output([sys.executable, "-P", "-c", program], env=environment))
    return read, written


@needs_sandbox
@pytest.mark.parametrize("stage", ["initialise", "train", "encode", "help"])
def test_a_stage_reads_its_capture_and_given_files_and_writes_its_run(home: Home, run: Path, stage: str) -> None:
    read, written = read_and_written(home, stage, run)
    assert read == ["capture", "masks", "mesh.ply", "run", "sound.wav", "tmp"]
    assert written == ["run", "tmp"]


@needs_sandbox
def test_a_stage_sees_nothing_of_other_processes_and_ends_its_own(home: Home, run: Path) -> None:
    program = f"""
import os, subprocess
from pathlib import Path
from jobs.home.home import Home
from jobs.process.process_tree import ProcessTree, keep_orphans
from jobs.process.stage_sandbox import enter_stage_sandbox
keep_orphans()
enter_stage_sandbox(Home.from_environment(), "train", Path({str(run)!r}))
for secret in ("environ", "stat", "root/etc/hostname"):
    try:
        Path("/proc/{os.getpid()}", secret).read_bytes()
    except PermissionError:
        print(secret)
orphan = int(subprocess.check_output(["sh", "-c", "setsid sleep 1000 >/dev/null 2>&1 & echo $!"]))
child = subprocess.Popen(["sleep", "1000"], start_new_session=True).pid
ProcessTree(os.getpid()).kill()
for pid in (orphan, child):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        print("ended")
"""
    environment = {**os.environ, **home.environment(), "TMPDIR": str(run.parent / "tmp")}
    told = subprocess.check_output([sys.executable, "-P", "-c", program], env=environment, text=True)
    assert told.split() == ["environ", "stat", "root/etc/hostname", "ended", "ended"]


@needs_sandbox
def test_a_stage_of_a_damaged_run_reads_the_run(home: Home, run: Path) -> None:
    (run / "run.json").write_text("{")
    assert read_and_written(home, "train", run)[0] == ["run", "tmp"]


@needs_sandbox
def test_a_stage_that_reaches_the_store_has_no_sandbox(home: Home, run: Path) -> None:
    assert "others" in read_and_written(home, "publish", run)[1]
    shared = {"store_url": "s3://bucket/prefix", "database_url": "postgresql+psycopg://host/name"}
    apart = dataclasses.replace(home, run_state="store", **shared)
    assert "others" in read_and_written(apart, "help", run)[1]
    assert "others" not in read_and_written(apart, "encode", run)[0]


@needs_sandbox
def test_stages_beside_a_gpu_have_no_sandbox(home: Home, run: Path) -> None:
    gpu = "stage_sandbox._GPUS = (Path('/dev/null'),)"
    assert "others" in read_and_written(home, "train", run, gpu)[1]


def test_a_gpu_is_named_as_a_gap(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stage_sandbox, "_GPUS", ())
    assert missing_from_stages() == missing_from_sandbox()
    monkeypatch.setattr(stage_sandbox, "_GPUS", (Path("/dev/null"),))
    assert missing_from_stages().startswith("stages of jobs run without a sandbox: this machine has a GPU")
