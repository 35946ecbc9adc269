"""The captures that a server offers, as far as readers have told of them."""

from __future__ import annotations

import asyncio
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from jobs.home.home import Home
from server.captures import capture_list as module
from server.captures.capture_folders import CaptureFolders
from server.captures.capture_list import CaptureList
from server.captures.capture_readers import CaptureReaders
from server.http.problem_error import ProblemError

READER = """
import json, os, pathlib, signal, sys, time
asked, root = json.loads(sys.stdin.readline()), pathlib.Path({root!r})
if sys.argv[1] == "find":
    found = [{{"name": one.name, "capture": str(one), "mark": one.read_text(), "layout": "N3DV", "cameras": []}}
             for one in sorted(root.iterdir())]
    print(json.dumps({{"captures": found, "complete": True}}))
else:
    for capture in map(pathlib.Path, asked["captures"]):
        with open({log!r}, "a") as log:
            log.write(capture.name + " ")
        how = capture.read_text()
        if how == "dies":
            os.kill(os.getpid(), signal.SIGSEGV)
        while how == "hangs":
            time.sleep(1)
        if how == "refused":
            told = {{"refused": [str(capture / "cam1.mp4"), "is damaged", "copy it again"]}}
        else:
            told = {{"found": {{"layout": "N3DV", "cameras": ["a"], "frames": 9, "seconds": 1.0, "problem": None}}}}
        print(json.dumps(told), flush=True)
"""


@pytest.fixture
def root(tmp_path: Path) -> Path:
    (tmp_path / "captures").mkdir()
    return tmp_path / "captures"


@pytest.fixture
def read(tmp_path: Path) -> Callable[[], list[str]]:
    """Return a function that tells which captures were opened, in order."""

    def names() -> list[str]:
        log = tmp_path / "log"
        return log.read_text().split() if log.exists() else []

    return names


@pytest.fixture
def make(root: Path, tmp_path: Path) -> Callable[..., CaptureList]:
    """Return a function that makes a list of files that stand for captures and behave as their text orders."""

    def list_of(captures: dict[str, str], patience: float = 600.0) -> CaptureList:
        for name, text in captures.items():
            (root / name).write_text(text)
        program = READER.format(root=str(root), log=str(tmp_path / "log"))
        readers = CaptureReaders(Home.at(tmp_path), lambda operation, note: [sys.executable, "-c", program, operation])
        return CaptureList(CaptureFolders((root,)), readers, patience)

    return list_of


def listed(captures: CaptureList, times: int = 1) -> dict[str, dict[str, Any]]:
    """List the captures so often; return those of the last time, by name."""

    async def ask() -> dict[str, Any]:
        for _ in range(times):
            answer = await captures.describe()
        return answer

    return {one["name"]: one for one in asyncio.run(ask())["captures"]}


def test_a_capture_is_told_as_its_reader_described_it(make: Callable[..., CaptureList], root: Path) -> None:
    assert listed(make({"a": "well"})) == {
        "a": {
            "capture": str(root / "a"),
            "name": "a",
            "layout": "N3DV",
            "cameras": ["a"],
            "frames": 9,
            "seconds": 1.0,
            "problem": None,
            "looking": False,
        },
    }


def test_a_capture_that_is_not_read_yet_has_every_field(make: Callable[..., CaptureList]) -> None:
    found = listed(make({"a": "refused", "b": "hangs"}, patience=1.0))
    unknown = {"frames": None, "seconds": None, "picture": None, "presets": None}
    assert all(unknown.items() <= told.items() for told in found.values())


def test_a_refused_capture_is_told_by_its_name_and_not_by_the_path_of_its_folder(
    make: Callable[..., CaptureList],
) -> None:
    found = listed(make({"a": "refused", "b": "well"}))
    assert found["a"]["problem"] == "a/cam1.mp4: is damaged; copy it again"
    assert found["b"]["problem"] is None


def test_a_capture_that_ends_its_reader_is_unreadable_and_the_others_are_there(
    make: Callable[..., CaptureList], read: Callable[[], list[str]]
) -> None:
    found = listed(make({"a": "well", "b": "dies", "c": "well", "d": "dies"}))
    for name in ("b", "d"):
        assert f"{name}: is damaged or malicious" in found[name]["problem"]
        assert "(SIGSEGV); export the file again" in found[name]["problem"]
    assert (found["a"]["problem"], found["c"]["problem"]) == (None, None)
    assert read() == ["a", "b", "b", "c", "d", "d"]  # a capture that ends a reader is read alone once more


def test_only_what_has_changed_is_opened_again(
    make: Callable[..., CaptureList], root: Path, read: Callable[[], list[str]]
) -> None:
    captures = make({"a": "well", "b": "refused", "c": "dies"})
    listed(captures, times=3)
    before = read()
    assert before == ["a", "b", "c", "c"]
    (root / "b").write_text("well")
    assert listed(captures)["b"]["problem"] is None
    assert read() == [*before, "b"]


def test_that_a_capture_has_ended_its_reader_is_believed_for_a_while(
    make: Callable[..., CaptureList], read: Callable[[], list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_KEPT_SECONDS", 0.0)
    captures = make({"a": "dies"}, patience=0.0)
    listed(captures)
    while len(read()) < 2:
        listed(captures)
        time.sleep(0.05)


def test_a_capture_that_takes_long_is_listed_as_being_looked_at(make: Callable[..., CaptureList]) -> None:
    captures = make({"a": "hangs"}, patience=0.0)
    found = listed(captures)["a"]
    assert (found["looking"], found["layout"], found["frames"]) == (True, "N3DV", None)
    assert found["problem"] == "a: is being read; try again in a few seconds"
    captures._readers.close()  # ends hanging readers
    captures.close()


def test_a_list_that_readers_cannot_make_says_so(root: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-c", "raise SystemExit(3)"]
    captures = CaptureList(CaptureFolders((root,)), CaptureReaders(Home.at(tmp_path), lambda *_: command))
    with pytest.raises(ProblemError, match="the capture folders cannot be read") as raised:
        asyncio.run(captures.describe())
    assert (raised.value.status, raised.value.code) == (503, "captures-unavailable")


def test_callers_of_one_moment_share_a_look(make: Callable[..., CaptureList], read: Callable[[], list[str]]) -> None:
    captures = make({"a": "well"})

    async def ask() -> list[dict[str, Any]]:
        return await asyncio.gather(*(captures.describe() for _ in range(20)))

    answers = asyncio.run(ask())
    assert {json.dumps(one) for one in answers} == {json.dumps(answers[0])}
    assert read() == ["a"]


def test_folders_are_named_whether_they_are_there_or_not(root: Path, tmp_path: Path) -> None:
    captures = CaptureList(CaptureFolders((root, root / "missing")), CaptureReaders(Home.at(tmp_path)))
    assert asyncio.run(captures.describe()) == {
        "captures": [],
        "complete": True,
        "folders": [{"path": str(root), "exists": True}, {"path": str(root / "missing"), "exists": False}],
    }
