from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.runs.given_files import GivenFiles
from hgs_core.runs.run_config import RunConfig
from jobs.home.home import Home
from server.captures.capture_readers import CaptureReaders
from server.captures.run_creation import LimitedCreation

READER = """
import json, os, pathlib, signal, sys
asked = json.loads(sys.stdin.readline())
capture, run = pathlib.Path(asked["capture"]), pathlib.Path(asked["run"])
with open({log!r}, "a") as log:
    log.write("x")
how = (capture / "how").read_text()
if how == "dies":
    os.kill(os.getpid(), signal.SIGSEGV)
if how == "refused":
    print(json.dumps({{"refused": ["cam1.mp4", "is short", "copy it"]}}))
elif how == "full":
    print(json.dumps({{"errno": 28, "error": "no space"}}))
else:
    run.mkdir(parents=True, exist_ok=True)
    (run / "run.json").write_text(asked.get("audio", "auto"))
    if how == "more":
        (run / "points.npz").touch()
    print(json.dumps({{"found": {{"config": asked["config"] | {{"seed": 5}}}}}}))
"""


@pytest.fixture
def creation(tmp_path: Path) -> LimitedCreation:
    program = READER.format(log=str(tmp_path / "log"))
    return LimitedCreation(CaptureReaders(Home.at(tmp_path), lambda *_: [sys.executable, "-c", program]))


@pytest.fixture
def create(creation: LimitedCreation, tmp_path: Path) -> Callable[..., RunConfig]:
    """Return a function that begins a run of a capture that behaves in some way; each run has its own folder."""
    (tmp_path / "capture").mkdir()

    def begin(how: str, run: str, audio: str = "auto") -> RunConfig:
        file = tmp_path / "capture" / "how"
        if not file.exists() or file.read_text() != how:
            file.write_text(how)
        return creation.create_run(tmp_path / run, tmp_path / "capture", RunConfig(), GivenFiles(audio=audio))

    return begin


def looks(tmp_path: Path) -> int:
    """How many times the capture was opened."""
    return (tmp_path / "log").stat().st_size


def test_a_capture_is_not_opened_again_for_the_same_wish(create: Callable[..., RunConfig], tmp_path: Path) -> None:
    configs = [create("well", run) for run in ("one", "two")]
    assert [config.seed for config in configs] == [5, 5]  # the pipeline's choice
    assert (tmp_path / "two" / "run.json").read_text() == "auto"
    assert looks(tmp_path) == 1
    create("well", "three", audio="none")  # another wish
    assert ((tmp_path / "three" / "run.json").read_text(), looks(tmp_path)) == ("none", 2)


def test_a_capture_that_has_changed_is_opened_again(create: Callable[..., RunConfig], tmp_path: Path) -> None:
    for run in ("one", "two"):
        with pytest.raises(InputError, match=r"cam1.mp4: is short; copy it"):
            create("refused", run)
    assert looks(tmp_path) == 1
    create("well", "three")
    assert looks(tmp_path) == 2


def test_a_capture_that_ends_its_reader_is_refused_and_tried_again_later(
    create: Callable[..., RunConfig], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for run in ("one", "two"):
        with pytest.raises(InputError, match=r"malicious.*\(SIGSEGV\); export the file again, or leave it out"):
            create("dies", run)
    assert looks(tmp_path) == 1
    monkeypatch.setattr(time, "monotonic", lambda: float("inf"))
    with pytest.raises(InputError, match="SIGSEGV"):
        create("dies", "three")
    assert looks(tmp_path) == 2


def test_what_is_no_fault_of_the_capture_is_not_kept(create: Callable[..., RunConfig], tmp_path: Path) -> None:
    for run in ("one", "two"):
        with pytest.raises(OSError, match="no space"):
            create("full", run)
    assert looks(tmp_path) == 2


def test_a_run_of_more_files_is_begun_anew_each_time(create: Callable[..., RunConfig], tmp_path: Path) -> None:
    for run in ("one", "two"):
        create("more", run)
        assert (tmp_path / run / "points.npz").exists()
    assert looks(tmp_path) == 2
