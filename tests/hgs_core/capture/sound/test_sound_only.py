"""A microphone's recording beside the videos is none of them."""

from __future__ import annotations

from pathlib import Path

import av
import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.calibrate.uncalibrated import find_videos
from hgs_core.capture.open import open_capture
from hgs_core.capture.sound.sound_only import is_sound_only
from tests.hgs_core.capture.layouts import CAMERAS, NAMES, PICTURES


def write_sound(path: Path) -> None:
    with av.open(str(path), "w") as container:
        stream = container.add_stream("aac", rate=48000, layout="mono")
        frame = av.AudioFrame.from_ndarray(np.zeros((1, 1024), np.float32), format="fltp", layout="mono")
        frame.sample_rate, frame.pts = 48000, 0
        container.mux(stream.encode(frame))
        container.mux(stream.encode())


def test_sound_without_pictures_is_known(tmp_path: Path) -> None:
    write_sound(tmp_path / "boom.mp4")
    PICTURES["videos"](tmp_path)
    (tmp_path / "torn.mp4").write_bytes(b"torn")
    assert [is_sound_only(tmp_path / name) for name in ("boom.mp4", "cam01.mp4", "torn.mp4", "gone.mp4")] == [
        True,
        False,
        False,
        False,
    ]


def test_it_is_left_aside_and_no_finding(tmp_path: Path) -> None:
    write_sound(tmp_path / "boom.mp4")
    PICTURES["videos"](tmp_path)
    CAMERAS["COLMAP text"](tmp_path)
    opened = open_capture(tmp_path)
    assert opened.left_out == ()
    assert "boom in the folder is sound without pictures and left aside" in opened.notes


def test_it_is_not_counted_where_poses_are_missing(tmp_path: Path) -> None:
    write_sound(tmp_path / "boom.mp4")
    PICTURES["videos"](tmp_path)
    with pytest.raises(
        InputError,
        match=r"there are 4 videos but no file of the cameras' poses, of .*; have them found: hgs cameras \S+$",
    ):
        open_capture(tmp_path)
    assert list(find_videos(tmp_path)) == list(NAMES)
