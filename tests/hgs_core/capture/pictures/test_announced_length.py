"""The length that a video's header states."""

from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.pictures.announced_length import announced_length
from tests.hgs_core.capture.layouts import picture, write_video


def video(path: Path, frames: int, stamps: list[int] | None = None) -> Path:
    """Write so many frames; `stamps` are their times in ms, in place of 30 a second."""
    write_video(path, [picture(0, frame) for frame in range(frames)], rate=30, stamps=stamps)
    return path


def test_even_frames_have_one_rate_and_a_length_in_seconds(tmp_path: Path) -> None:
    length = announced_length(video(tmp_path / "a.mp4", 12))
    assert length == (12, 30.0, True)
    assert length.seconds == pytest.approx(0.4)


def test_uneven_frames_have_a_mean_rate(tmp_path: Path) -> None:
    stamps = [0, 33, 67, 100, 133, 167, 400, 433, 467, 667]
    length = announced_length(video(tmp_path / "a.mp4", 10, stamps))
    assert (length.frames, length.even) == (10, False)
    assert length.rate is not None
    assert 10 < length.rate < 20


def test_a_header_without_a_number_of_frames_states_no_seconds(tmp_path: Path) -> None:
    length = announced_length(video(tmp_path / "a.mkv", 12))
    assert (length.frames, length.seconds) == (None, None)


def test_a_file_that_is_no_video_is_refused_by_name(tmp_path: Path) -> None:
    path = tmp_path / "a.mp4"
    path.write_bytes(b"not a video")
    with pytest.raises(InputError, match=r"a\.mp4: the video is unreadable"):
        announced_length(path)
