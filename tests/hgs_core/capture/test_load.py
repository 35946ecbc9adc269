"""Every reader of cameras with every reader of pictures, and outlines of captures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.camera_formats import calibration
from hgs_core.capture.capture import Capture
from hgs_core.capture.load import Outline, outline
from hgs_core.capture.open import open_capture
from tests.hgs_core.capture import layouts
from tests.hgs_core.capture.conftest import SAMPLE
from tests.hgs_core.capture.layouts import CAMERAS, FRAMES, NAMES, PICTURES, level


def outlined(path: Path) -> Outline:
    return outline(path, *next(calibration(path)))


def shown(capture: Capture) -> list[list[int]]:
    """The greys of all pictures, to the tens: limited range costs a level."""
    frames = range(len(capture.times))
    return [[10 * round(float(capture.frame(c, f).mean()) / 10) for f in frames] for c in range(len(capture.cameras))]


def assert_whole(capture: Capture) -> None:
    """All four cameras are there, equal to the truth, with all their pictures in order."""
    assert shown(capture) == [[level(camera, frame) for frame in range(FRAMES)] for camera in range(len(NAMES))]
    np.testing.assert_allclose(capture.times, np.arange(FRAMES) / 30, atol=1e-9)
    for camera, true in zip(capture.cameras, layouts.truth(), strict=True):
        np.testing.assert_allclose(camera.world_to_camera, true.world_to_camera, atol=1e-6)
        found = camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy
        assert found == pytest.approx((true.width, true.height, true.fx, true.fy, true.cx, true.cy), abs=1e-6)


@pytest.mark.parametrize("pictures", PICTURES)
@pytest.mark.parametrize("cameras", CAMERAS)
def test_any_cameras_go_with_any_pictures(tmp_path: Path, cameras: str, pictures: str) -> None:
    CAMERAS[cameras](tmp_path)
    PICTURES[pictures](tmp_path)
    assert_whole(open_capture(tmp_path))


@pytest.mark.parametrize(
    "time", [None, lambda frame: frame / FRAMES, lambda frame: 7.5 + frame / 30, lambda frame: 100 + frame]
)
def test_frames_of_one_pose_are_the_pictures_of_a_fixed_camera(tmp_path: Path, time) -> None:  # type: ignore[no-untyped-def]
    """Without times they come in the order of their names; times are shares of the whole, seconds or frame numbers."""
    pattern = "images/{camera}/{frame}.png"
    layouts.folders(pattern)(tmp_path)
    layouts.transforms(layouts.frames_of_pictures(pattern, time))(tmp_path)
    capture = open_capture(tmp_path)
    assert_whole(capture)
    assert tuple(camera.name for camera in capture.cameras) == NAMES


def test_masks_lie_beside_the_pictures_of_any_layout(tmp_path: Path) -> None:
    from PIL import Image

    layouts.easymocap(tmp_path)
    layouts.folders("images/{camera}/{frame:06d}.png")(tmp_path)
    for frame in range(FRAMES):
        mask = np.zeros((layouts.HEIGHT, layouts.WIDTH), np.uint8)
        mask[:, frame] = 255
        path = tmp_path / "masks" / "cam02" / f"{frame:06d}.png"
        path.parent.mkdir(parents=True, exist_ok=True)
        Image.fromarray(mask).save(path)
    capture = open_capture(tmp_path)
    moving = capture.mask(1, 3)
    assert moving is not None
    assert np.unique(np.argwhere(moving)[:, 1]).tolist() == [3]
    assert capture.mask(0, 3) is None


def test_of_two_calibrations_one_is_taken_and_a_note_says_which(tmp_path: Path) -> None:
    layouts.llff(tmp_path)
    layouts.colmap(True)(tmp_path)
    PICTURES["videos"](tmp_path)
    note = "the cameras are those of poses_bounds.npy; sparse/0/images.bin is left aside"
    assert note in open_capture(tmp_path).notes


def test_the_rate_of_pictures_in_folders_is_assumed_and_said(tmp_path: Path) -> None:
    layouts.llff(tmp_path)
    PICTURES["folders"](tmp_path)
    assert any("30 pictures per second are assumed" in note for note in open_capture(tmp_path).notes)
    (tmp_path / "sync.json").write_text('{"rate": 25}')
    capture = open_capture(tmp_path)
    np.testing.assert_allclose(capture.times, np.arange(FRAMES) / 25)
    assert not any("assumed" in note for note in capture.notes)


def test_pictures_of_one_moment_are_a_still_scene(tmp_path: Path) -> None:
    layouts.colmap(True)(tmp_path)
    layouts.folders("images/{camera}.png")(tmp_path)
    assert open_capture(tmp_path).times.tolist() == [0.0]


@pytest.mark.parametrize("pictures", ["videos", "folders", "moments"])
def test_a_capture_is_outlined_as_it_opens(tmp_path: Path, pictures: str) -> None:
    layouts.colmap(False)(tmp_path)
    PICTURES[pictures](tmp_path)
    found, capture = outlined(tmp_path), open_capture(tmp_path)
    assert found.cameras == tuple(camera.name for camera in capture.cameras)
    assert (found.frames, found.seconds) == (FRAMES, pytest.approx(FRAMES / 30))


def test_videos_are_outlined_by_the_first_header() -> None:
    assert outlined(SAMPLE).seconds == 2.0


@pytest.mark.parametrize("content", [b"", b"no video"])
def test_a_damaged_video_is_named_by_the_outline(tmp_path: Path, content: bytes) -> None:
    layouts.llff(tmp_path)
    PICTURES["videos"](tmp_path)
    (tmp_path / "cam01.mp4").write_bytes(content)
    with pytest.raises(InputError, match=r"cam01\.mp4: the video is unreadable"):
        outlined(tmp_path)


def test_a_camera_of_far_larger_pictures_is_named_with_the_option_that_helps(tmp_path: Path) -> None:
    CAMERAS["poses_bounds.npy"](tmp_path)
    PICTURES["videos"](tmp_path)
    large = np.full((4 * layouts.HEIGHT, 4 * layouts.WIDTH, 3), 90, np.uint8)
    layouts.write_video(tmp_path / f"{NAMES[1]}.mp4", [large] * FRAMES)
    notes = " ".join(open_capture(tmp_path).notes)
    assert f"pictures of {NAMES[1]} have 192x128 pixels, 16 times as many as most" in notes
    assert f"--downscale {NAMES[1]}=4" in notes
