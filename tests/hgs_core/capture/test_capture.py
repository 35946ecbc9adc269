"""The capture: detection of layouts, the bounded cache, threads, and the fingerprint."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from av import VideoFrame

from hgs_core.base.errors import InputError
from hgs_core.capture.capture import Capture
from hgs_core.capture.open import open_capture
from hgs_core.capture.pictures.video import VideoReader
from hgs_core.scene.camera import Camera

PICTURE = 64 * 48 * 3


def level(picture: np.ndarray) -> int:
    return 10 * round(float(picture.mean()) / 10)  # limited range costs a level


def test_frames_in_a_time_are_at_least_one_and_at_most_all(panoptic: Path) -> None:
    capture = open_capture(panoptic)
    frame = float(capture.times[1] - capture.times[0])
    found = [capture.frames_in(seconds) for seconds in (0.01 * frame, 2.4 * frame, 1000 * frame)]
    assert found == [1, 2, len(capture.times)]


def test_unknown_camera_lists_those_there_are(panoptic: Path) -> None:
    capture = open_capture(panoptic)
    assert capture.camera_index("17") == 1
    with pytest.raises(InputError, match="no camera 'cam00'; the cameras are 3, 17"):
        capture.camera_index("cam00")


@pytest.mark.parametrize(("camera", "frame"), [(2, 0), (-1, 0), (0, 6), (0, -1)])
def test_indices_outside_are_refused(panoptic: Path, camera: int, frame: int) -> None:
    with pytest.raises(IndexError):
        open_capture(panoptic).frame(camera, frame)


def test_pictures_are_read_only(n3dv: Path) -> None:
    picture = open_capture(n3dv).frame(0, 3)
    with pytest.raises(ValueError, match="read-only"):
        picture[0, 0] = 0


@pytest.mark.parametrize("budget", [0, PICTURE, 3 * PICTURE, 100 * PICTURE])
def test_the_cache_never_holds_more_than_its_budget(n3dv: Path, budget: int) -> None:
    capture = open_capture(n3dv, cache_bytes=budget)
    for frame in (5, 0, 3, 1, 4, 2):
        for camera in (0, 1):
            assert level(capture.frame(camera, frame)) == 20 + 60 * camera + 10 * frame
            assert capture._pictures.bytes_in_memory <= budget


class CountingSource:
    """A source that counts decoded pictures and fails on overlapping calls for one camera."""

    def __init__(self) -> None:
        self.reads: list[tuple[int, int]] = []
        self.busy = [False, False]

    def read(self, camera: int, frame: int, neighbours: int) -> tuple[np.ndarray, list[tuple[int, np.ndarray]]]:
        assert not self.busy[camera]
        self.busy[camera] = True
        self.reads.append((camera, frame))
        picture = np.full((48, 64, 3), 100 * camera + frame, np.uint8)
        self.busy[camera] = False
        return picture, []

    def read_mask(self, camera: int, frame: int) -> None:
        return None


def counting_capture(names: tuple[str, ...] = ("a", "b")) -> tuple[Capture, CountingSource]:
    cameras = [Camera(name, 64, 48, 50, 50, 32, 24, np.eye(4)) for name in names]
    source = CountingSource()
    return Capture(Path("x"), cameras, np.arange(20) / 30, source, "f", cache_bytes=1 << 24), source


def test_many_threads_decode_every_picture_once() -> None:
    capture, source = counting_capture()
    wanted = [(camera, frame) for frame in range(20) for camera in (0, 1)] * 8
    with ThreadPoolExecutor(8) as pool:
        pictures = list(pool.map(lambda pair: capture.frame(*pair), wanted))
    assert [int(p[0, 0, 0]) for p in pictures] == [100 * camera + frame for camera, frame in wanted]
    assert len(source.reads) == len(set(source.reads)) == 40


def test_threads_share_one_video_capture(n3dv: Path) -> None:
    capture = open_capture(n3dv, cache_bytes=2 * PICTURE)
    wanted = [(camera, frame) for camera in (0, 1) for frame in (0, 5, 2, 3, 1, 4)] * 4
    with ThreadPoolExecutor(4) as pool:
        levels = list(pool.map(lambda pair: level(capture.frame(*pair)), wanted))
    assert levels == [20 + 60 * camera + 10 * frame for camera, frame in wanted]


@pytest.fixture
def converted(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Decoded frames that became pictures, in order."""
    found: list[int] = []
    picture = VideoReader._picture

    def counted(video: VideoReader, frame: VideoFrame) -> np.ndarray:
        found.append(video._next)
        return picture(video, frame)

    monkeypatch.setattr(VideoReader, "_picture", counted)
    return found


def test_blocks_of_time_convert_each_frame_once(n3dv: Path, converted: list[int]) -> None:
    """The trainer visits a block of frames in all cameras in any order, then the next block."""
    capture = open_capture(n3dv, cache_bytes=2 * 3 * PICTURE)  # three frames of two cameras
    for block in ((2, 0, 1), (5, 3, 4)):
        for frame in block:
            for camera in (0, 1):
                capture.frame(camera, frame)
    assert len(converted) == 12


def test_frames_on_the_way_become_pictures_only_where_all_fit(n3dv: Path, converted: list[int]) -> None:
    small = open_capture(n3dv, cache_bytes=2 * 3 * PICTURE)
    converted.clear()
    assert level(small.frame(0, 5)) == 70
    assert len(converted) == 1
    large = open_capture(n3dv, cache_bytes=2 * 6 * PICTURE)
    converted.clear()
    assert [level(large.frame(0, frame)) for frame in (5, 4)] == [70, 60]
    assert converted == [5, 6]  # 4 on the way from a key frame, and 5


def test_two_cameras_of_one_name_are_refused() -> None:
    with pytest.raises(InputError, match="two cameras are called a"):
        counting_capture(("a", "a"))


@pytest.mark.parametrize("layout", ["n3dv", "panoptic"])
def test_the_fingerprint_follows_the_files(layout: str, request: pytest.FixtureRequest) -> None:
    root: Path = request.getfixturevalue(layout)
    before = open_capture(root).fingerprint()
    assert open_capture(root).fingerprint() == before
    poses = root / ("poses_bounds.npy" if layout == "n3dv" else "train_meta.json")
    if layout == "n3dv":
        values = np.load(poses)
        values[0, 3] += 1e-3
        np.save(poses, values)
    else:
        poses.write_text(poses.read_text() + " ")
    assert open_capture(root).fingerprint() != before


def test_the_fingerprint_follows_sizes(n3dv: Path) -> None:
    before = open_capture(n3dv).fingerprint()
    with (n3dv / "cam00.mp4").open("ab") as file:
        file.write(b"\0\0\0\x08free")
    assert open_capture(n3dv).fingerprint() != before
