"""The pictures that a capture holds: in memory where all fit, on disk where they do not, decoded once either way."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hgs_core.base.progress import Progress, silent
from hgs_core.capture.capture import Capture
from hgs_core.capture.held_pictures import shared_pictures
from hgs_core.scene.camera import Camera

FRAMES = 20
PICTURE = 48 * 64 * 3
EVERYTHING = 2 * FRAMES * PICTURE


class CountingSource:
    """A source of pictures of one level each, with a list of those read."""

    def __init__(self) -> None:
        self.reads: list[tuple[int, int]] = []

    def read(self, camera: int, frame: int, neighbours: int) -> tuple[np.ndarray, list[tuple[int, np.ndarray]]]:
        self.reads.append((camera, frame))
        return np.full((48, 64, 3), 100 * camera + frame, np.uint8), []

    def read_mask(self, camera: int, frame: int) -> None:
        return None

    def mask_file(self, camera: int, frame: int) -> None:
        return None


def capture_of(
    memory: int, *, fingerprint: str = "f", focal: float = 50, late: int = 0
) -> tuple[Capture, CountingSource]:
    cameras = [Camera(name, 64, 48, focal, 50, 32, 24, np.eye(4)) for name in "ab"]
    source = CountingSource()
    times, numbers = np.arange(FRAMES) / 30, np.arange(FRAMES) + np.array([[0], [late]])
    return Capture(Path("x"), cameras, times, source, fingerprint, cache_bytes=memory, numbers=numbers), source


def level(capture: Capture, camera: int, frame: int) -> int:
    picture = capture.frame(camera, frame)
    assert not picture.flags.writeable
    return int(picture[0, 0, 0])


def test_pictures_of_a_large_capture_are_decoded_once_onto_the_disk(tmp_path: Path) -> None:
    capture, source = capture_of(4 * PICTURE)
    capture.keep_on_disk(tmp_path / "pictures", EVERYTHING)
    capture.hold((0, 1), range(FRAMES))
    assert sorted(source.reads) == [(camera, frame) for camera in (0, 1) for frame in range(FRAMES)]
    random = np.random.default_rng(0)
    for camera, frame in zip(random.integers(2, size=100), random.integers(FRAMES, size=100), strict=True):
        assert level(capture, int(camera), int(frame)) == 100 * camera + frame
    assert len(source.reads) == 2 * FRAMES
    again, other = capture_of(4 * PICTURE)  # the next stage of the run
    again.keep_on_disk(tmp_path / "pictures", EVERYTHING)
    again.hold((0, 1), range(FRAMES))
    assert level(again, 1, 7) == 107
    assert other.reads == []


def test_pictures_of_a_small_capture_are_decoded_once_into_memory(tmp_path: Path) -> None:
    capture, source = capture_of(2 * EVERYTHING)
    capture.keep_on_disk(tmp_path / "pictures", 10 * EVERYTHING)
    capture.hold((0, 1), range(FRAMES))
    assert [level(capture, 1, frame) for frame in (5, 0, 19)] == [105, 100, 119]
    assert len(source.reads) == 2 * FRAMES
    assert not (tmp_path / "pictures").exists()


def test_the_next_stage_decodes_no_picture_again_where_pictures_are_shared() -> None:
    with shared_pictures():
        capture, _ = capture_of(EVERYTHING)
        capture.hold((0, 1), range(FRAMES))
        del capture
        again, source = capture_of(EVERYTHING)
        assert level(again, 1, 7) == 107
    assert source.reads == []
    later, source = capture_of(EVERYTHING)
    assert level(later, 1, 7) == 107
    assert source.reads == [(1, 7)]


@pytest.mark.parametrize(
    "other",
    [
        {"fingerprint": "g"},
        {"focal": 51},
        {"late": 1},
        {"memory": EVERYTHING - 1},
    ],
    ids=["files", "lens", "clock", "memory"],
)
def test_pictures_of_another_capture_are_not_shared(other: dict[str, Any]) -> None:
    with shared_pictures():
        level(capture_of(EVERYTHING)[0], 1, 7)
        different, source = capture_of(**{"memory": EVERYTHING, **other})
        level(different, 1, 7)
    assert source.reads == [(1, 7)]


def test_pictures_that_do_not_fit_in_memory_are_not_shared() -> None:
    with shared_pictures():
        for _ in range(2):
            capture, source = capture_of(EVERYTHING - 1)
            level(capture, 1, 7)
            assert source.reads == [(1, 7)]


def test_nothing_is_decoded_ahead_that_does_not_fit(tmp_path: Path) -> None:
    capture, source = capture_of(4 * PICTURE)
    capture.hold((0, 1), range(FRAMES))
    assert source.reads == []
    capture.keep_on_disk(tmp_path / "pictures", 10 * PICTURE)
    capture.hold((0, 1), range(6))
    assert source.reads == []
    capture.hold((0, 1), range(5))
    assert len(source.reads) == 10


def test_the_next_block_takes_the_room_of_the_last(tmp_path: Path) -> None:
    capture, source = capture_of(4 * PICTURE)
    capture.keep_on_disk(tmp_path / "pictures", 10 * PICTURE)
    for block in (range(5), range(5, 10)):
        capture.hold((0, 1), block)
    held = sorted(int(path.stem) for path in (tmp_path / "pictures").glob("0/*.rgb"))
    assert held == list(range(5, 10))
    assert level(capture, 0, 2) == 2  # decoded once more
    assert len(source.reads) == 21


def test_a_picture_that_another_process_removed_is_decoded_again(tmp_path: Path) -> None:
    capture, source = capture_of(4 * PICTURE)
    capture.keep_on_disk(tmp_path / "pictures", EVERYTHING)
    capture.hold((0, 1), range(FRAMES))
    (tmp_path / "pictures" / "1" / "3.rgb").unlink()
    assert level(capture, 1, 3) == 103
    assert source.reads[2 * FRAMES :] == [(1, 3)]


def test_room_is_that_of_the_place_where_pictures_are_held(tmp_path: Path) -> None:
    capture, _ = capture_of(10 * PICTURE)
    assert capture.room == 8 * PICTURE  # the decoder passes others
    capture.keep_on_disk(tmp_path / "pictures", 7 * PICTURE)
    assert capture.room == 8 * PICTURE  # a disk that holds less than memory is left alone
    capture.keep_on_disk(tmp_path / "pictures", EVERYTHING)
    assert capture.room == EVERYTHING


@pytest.mark.parametrize("on_disk", [False, True])
def test_progress_is_reported_by_pictures(tmp_path: Path, on_disk: bool) -> None:
    reports: list[Progress] = []
    capture, _ = capture_of(PICTURE if on_disk else 2 * EVERYTHING)
    capture.keep_on_disk(tmp_path / "pictures", EVERYTHING)
    capture.hold((1,), range(FRAMES), reports.append)
    assert reports[-1] == Progress("frames", FRAMES, FRAMES)
    reports.clear()
    capture.hold((1,), range(FRAMES), reports.append)
    assert reports == []
    capture.hold((0,), range(FRAMES), silent)
