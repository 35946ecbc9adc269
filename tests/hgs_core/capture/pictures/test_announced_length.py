"""The length that a video's header states."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.pictures.announced_length import announced_length


def write_video(path: Path, stamps: list[int]) -> Path:
    """Write a grey frame at each time stamp, ticks of 1/30 s."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30)
        stream.width, stream.height, stream.pix_fmt, stream.time_base = 32, 32, "yuv420p", Fraction(1, 30)
        for stamp in stamps:
            frame = av.VideoFrame.from_ndarray(np.full((32, 32, 3), 100, np.uint8), format="rgb24")
            frame.pts, frame.time_base = stamp, Fraction(1, 30)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return path


def test_even_frames_have_one_rate_and_a_length_in_seconds(tmp_path: Path) -> None:
    length = announced_length(write_video(tmp_path / "a.mp4", list(range(12))))
    assert length == (12, 30.0, True)
    assert length.seconds == pytest.approx(0.4)


def test_uneven_frames_have_a_mean_rate(tmp_path: Path) -> None:
    length = announced_length(write_video(tmp_path / "a.mp4", [0, 1, 2, 3, 4, 5, 12, 13, 14, 20]))
    assert (length.frames, length.even) == (10, False)
    assert length.rate is not None
    assert 10 < length.rate < 20


def test_a_header_without_a_number_of_frames_states_no_seconds(tmp_path: Path) -> None:
    length = announced_length(write_video(tmp_path / "a.mkv", list(range(12))))
    assert (length.frames, length.seconds) == (None, None)


def test_a_file_that_is_no_video_is_refused_by_name(tmp_path: Path) -> None:
    path = tmp_path / "a.mp4"
    path.write_bytes(b"not a video")
    with pytest.raises(InputError, match=r"a\.mp4: the video is unreadable"):
        announced_length(path)
