"""Pictures of cameras, as far as a reader has told of them."""

from __future__ import annotations

import asyncio
import os
import sys
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from jobs.home.home import Home
from server.captures import camera_pictures as module
from server.captures.camera_pictures import CameraPictures
from server.captures.capture_folders import CaptureFolders
from server.captures.capture_readers import CaptureReaders
from server.http.problem_error import ProblemError

READER = """
import json, os, pathlib, signal, sys
capture = pathlib.Path(json.loads(sys.stdin.readline())["capture"])
with open({log!r}, "a") as log:
    log.write(capture.name + " ")
if capture.name == "refused":
    print(json.dumps({{"refused": [str(capture), "is no capture", ""]}}), flush=True)
    sys.exit()
for camera in ("a", "b"):
    print(json.dumps({{"found": {{"camera": camera, "picture": None if camera == "b" else "data:,"}}}}), flush=True)
    if capture.name == "dies":
        os.kill(os.getpid(), signal.SIGSEGV)
"""


@pytest.fixture
def pictures(tmp_path: Path) -> CameraPictures:
    program = READER.format(log=str(tmp_path / "log"))
    home = Home.at(tmp_path / "home")
    readers = CaptureReaders(home, lambda operation, note: [sys.executable, "-c", program, operation, str(note)])
    return CameraPictures(CaptureFolders((tmp_path,)), readers)


def test_pictures_are_told_by_camera(pictures: CameraPictures, tmp_path: Path) -> None:
    assert asyncio.run(pictures.of(tmp_path / "studio")) == {"a": "data:,", "b": None}


def test_a_crash_leaves_the_pictures_before_it_and_is_not_repeated_at_once(
    pictures: CameraPictures, tmp_path: Path
) -> None:
    for _ in range(2):
        assert asyncio.run(pictures.of(tmp_path / "dies")) == {"a": "data:,"}
    assert (tmp_path / "log").read_text().split() == ["dies"]


def test_a_capture_is_read_again_when_a_file_of_it_has_changed(pictures: CameraPictures, tmp_path: Path) -> None:
    file = tmp_path / "studio" / "left" / "0.png"
    file.parent.mkdir(parents=True)
    for content in ("first", "first", "other than the first"):
        file.write_text(content)
        os.utime(file, (5, 5))
        assert asyncio.run(pictures.of(tmp_path / "studio"))["a"] == "data:,"
    assert (tmp_path / "log").read_text().split() == ["studio", "studio"]


def test_a_refusal_is_told(pictures: CameraPictures, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is no capture"):
        asyncio.run(pictures.of(tmp_path / "refused"))


def test_those_who_ask_at_once_share_a_reader_and_many_captures_wait_in_vain(
    pictures: CameraPictures, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_MOST_WAITING", 2)

    async def ask() -> None:
        asked = [asyncio.ensure_future(pictures.of(tmp_path / name)) for name in ("studio", "studio", "park")]
        while len(pictures._under_way) < 2:
            await asyncio.sleep(0.01)
        with pytest.raises(ProblemError) as refused:
            await pictures.of(tmp_path / "third")
        assert (refused.value.status, refused.value.code) == (503, "server-busy")
        first, second, _ = await asyncio.gather(*asked)
        assert first == second

    asyncio.run(ask())
    assert (tmp_path / "log").read_text().split() == ["studio", "park"]
    assert asyncio.run(pictures.of(tmp_path / "third"))["a"] == "data:,"
