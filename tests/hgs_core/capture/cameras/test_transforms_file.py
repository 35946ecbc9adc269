"""The frames that transforms.json lists, and the pictures that they mean."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.transforms_file import read_frames
from hgs_core.capture.open import open_capture
from tests.hgs_core.capture import layouts

PATTERN = "images/{camera}/{frame:04d}.png"


@pytest.mark.parametrize(
    "written",
    [
        "images\\{camera}\\{frame:04d}.png",
        ".\\images\\{camera}\\{frame:04d}.png",
        "D:\\shots\\7\\images\\{camera}\\{frame:04d}.PNG",
        "/home/eva/shots/7/images/{camera}/{frame:04d}.png",
        "../7/images/{camera}/{frame:04d}.png",
        "shots/images/{camera}/{frame:04d}",
        "images/{camera}/{frame:04d}.jpg",
        "Images/{camera}/{frame:04d}",
        "images/%63am{camera[3]}{camera[4]}/{frame:04d}.png",
        " images/{camera}/{frame:04d}.png ",
    ],
)
def test_pictures_are_found_however_another_machine_called_them(tmp_path: Path, written: str) -> None:
    layouts.folders(PATTERN)(tmp_path)
    layouts.transforms(layouts.frames_of_pictures(written, lambda frame: frame / 30))(tmp_path)
    capture = open_capture(tmp_path)
    assert [camera.name for camera in capture.cameras] == list(layouts.NAMES)
    assert [int(capture.frame(2, frame)[0, 0, 0]) for frame in range(3)] == [layouts.level(2, i) for i in range(3)]
    assert sum("are written otherwise than the files there" in note for note in capture.notes) == 1


@pytest.mark.parametrize("ending", ["jpg", "JPG", "tiff"])
def test_a_missing_ending_is_that_of_the_file(tmp_path: Path, ending: str) -> None:
    layouts.folders(f"images/{{camera}}/{{frame}}.{ending}")(tmp_path)
    layouts.transforms(layouts.frames_of_pictures("images/{camera}/{frame}", lambda frame: frame / 30))(tmp_path)
    capture = open_capture(tmp_path)
    assert len(capture.times) == layouts.FRAMES
    assert not any("written otherwise" in note for note in capture.notes)


def test_fields_that_all_frames_would_repeat_take_no_memory(tmp_path: Path) -> None:
    layouts.folders(PATTERN)(tmp_path)
    layouts.transforms(layouts.frames_of_pictures(PATTERN, lambda frame: frame / 30))(tmp_path)
    file = tmp_path / "transforms.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | {f"field{i}": i for i in range(1000)}))
    frames, _ = read_frames(tmp_path, [file])
    assert max(len(frame.values) for frame in frames) < 20
    assert len(open_capture(tmp_path).times) == layouts.FRAMES


@pytest.mark.parametrize("name", ["Transforms.JSON", "TRANSFORMS.json"])
def test_the_file_may_be_called_in_capitals(tmp_path: Path, name: str) -> None:
    layouts.videos()(tmp_path)
    layouts.transforms(layouts.frames_of_videos(), name)(tmp_path)
    assert len(open_capture(tmp_path).cameras) == len(layouts.NAMES)


@pytest.mark.parametrize("name", ["n" * 300 + ".png", "a/" * 3 + "b" * 5000])
def test_a_name_that_no_file_can_have_is_refused(tmp_path: Path, name: str) -> None:
    layouts.videos()(tmp_path)
    frames = layouts.frames_of_videos()
    frames[1]["file_path"] = name
    layouts.transforms(frames)(tmp_path)
    with pytest.raises(InputError, match=r"frame 1: file_path .* is outside the capture"):
        open_capture(tmp_path)
