"""Packets of a video are read once, in this process and by means of a folder in others, until the file changes."""

from __future__ import annotations

import os
from pathlib import Path
from typing import NoReturn

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.pictures import video as video_module
from hgs_core.capture.pictures import video_index, video_packets
from hgs_core.capture.pictures.video import VideoReader
from hgs_core.capture.pictures.video_index import indexed_packets
from hgs_core.capture.pictures.video_packets import VideoPackets
from tests.hgs_core.capture.pictures.test_video_packets import write


@pytest.fixture
def video(tmp_path: Path) -> Path:
    return write(tmp_path / "cam00.mp4")


@pytest.fixture
def looks(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """The videos that were read from end to end."""
    looked: list[Path] = []
    whole = VideoPackets.of

    def counted(path: Path) -> VideoPackets:
        looked.append(path)
        return whole(path)

    monkeypatch.setattr(VideoPackets, "of", counted)
    return looked


def another_process() -> None:
    video_index._kept.clear()


def test_a_process_reads_the_packets_of_a_video_once(video: Path, looks: list[Path]) -> None:
    first, second = indexed_packets(video), indexed_packets(video)
    assert looks == [video]
    assert first == second


def test_a_folder_tells_other_processes(video: Path, looks: list[Path], tmp_path: Path) -> None:
    first = indexed_packets(video, tmp_path / "run")
    another_process()
    second = indexed_packets(video, tmp_path / "run")
    assert looks == [video]
    assert first == second


def test_an_indexed_video_is_not_opened_before_its_frames_are_read(
    video: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    VideoReader(video, index=tmp_path / "run")
    another_process()

    def opened(path: Path) -> NoReturn:
        raise AssertionError(f"{path} was opened")

    for module in (video_packets, video_module):
        monkeypatch.setattr(module, "open_container", opened)
    reader = VideoReader(video, index=tmp_path / "run")
    assert (reader.width, reader.height) == (64, 48)


def test_what_was_read_without_a_folder_is_written_to_the_next(video: Path, looks: list[Path], tmp_path: Path) -> None:
    indexed_packets(video)
    indexed_packets(video, tmp_path / "run")
    another_process()
    indexed_packets(video, tmp_path / "run")
    assert looks == [video]


def test_a_reader_with_an_index_gives_the_same_pictures_and_times(video: Path, tmp_path: Path) -> None:
    plain = VideoReader(video)
    another_process()
    VideoReader(video, index=tmp_path / "run")
    another_process()
    indexed = VideoReader(video, index=tmp_path / "run")
    np.testing.assert_array_equal(indexed.seconds, plain.seconds)
    for frame in (4, 1):
        np.testing.assert_array_equal(indexed.read(frame, 0)[0], plain.read(frame, 0)[0])


@pytest.mark.parametrize("process", ["this", "another"])
def test_a_video_that_changed_is_read_anew(video: Path, looks: list[Path], tmp_path: Path, process: str) -> None:
    indexed_packets(video, tmp_path / "run")
    before = video.stat()
    write(video, options={"g": "2"}, stamps=[0, 40, 80, 120, 160, 200])
    os.utime(video, ns=(before.st_atime_ns, before.st_mtime_ns + 1))
    if process == "another":
        another_process()
    assert indexed_packets(video, tmp_path / "run") == VideoPackets.of(video)
    assert looks == [video] * 3
    another_process()
    indexed_packets(video, tmp_path / "run")
    assert looks == [video] * 3


@pytest.mark.parametrize("damage", [b"", b"[]", b'{"state": 1}', None])
def test_a_damaged_index_is_made_anew(video: Path, looks: list[Path], tmp_path: Path, damage: bytes | None) -> None:
    indexed_packets(video, tmp_path / "run")
    (file,) = (tmp_path / "run").iterdir()
    good = file.read_bytes()
    file.write_bytes(good.replace(b'"turns":', b'"turn":') if damage is None else damage)
    another_process()
    indexed_packets(video, tmp_path / "run")
    assert looks == [video] * 2
    assert file.read_bytes() == good


def test_a_folder_that_cannot_be_written_is_done_without(video: Path, tmp_path: Path) -> None:
    (tmp_path / "run").write_text("a file")
    assert indexed_packets(video, tmp_path / "run") == VideoPackets.of(video)


def test_notes_of_one_reader_are_not_those_of_the_next(video: Path) -> None:
    VideoReader(video).notes.append("stretched")
    assert VideoReader(video).notes == []


def test_a_missing_video_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="the video is missing"):
        indexed_packets(tmp_path / "cam00.mp4")
