"""Videos of cameras that were held on their side or upside down: stored so, and marked to be turned."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import av
import numpy as np
import numpy.typing as npt
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.open import open_capture
from hgs_core.capture.pictures.video import VideoReader

Corners = npt.NDArray[np.uint8]
LEVELS = (40, 90, 150, 210)


@pytest.fixture
def upright() -> Corners:
    """A picture of 64x48 with four distinct quarters."""
    quarters = np.array(LEVELS, np.uint8).reshape(2, 2).repeat(24, 0).repeat(32, 1)
    return np.repeat(quarters[:, :, None], 3, 2)


def write(path: Path, picture: Corners, degrees: float, *, mirrored: bool = False, frames: int = 3) -> None:
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30, options={"crf": "0"})
        stream.height, stream.width = picture.shape[:2]
        stream.pix_fmt = "yuv444p"
        stream.set_display_rotation(degrees, mirrored)
        for _ in range(frames):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")))
        container.mux(stream.encode())


@pytest.mark.parametrize("suffix", ["mp4", "mov", "mkv"])
@pytest.mark.parametrize("turns", [0, 1, 2, 3])
def test_pictures_are_turned_upright(upright: Corners, tmp_path: Path, suffix: str, turns: int) -> None:
    path = tmp_path / f"cam00.{suffix}"
    write(path, np.rot90(upright, -turns), 90 * turns)
    reader = VideoReader(path)
    assert (reader.width, reader.height) == (64, 48)
    picture, passed = reader.read(2, 2)
    for shown in (picture, *(neighbour for _, neighbour in passed)):
        np.testing.assert_allclose(shown.astype(int), upright, atol=3)


def test_a_video_on_its_side_fits_poses_of_upright_pictures(n3dv: Path, upright: Corners) -> None:
    write(n3dv / "cam01.mp4", np.rot90(upright), -90, frames=6)
    capture = open_capture(n3dv)
    assert [(camera.width, camera.height) for camera in capture.cameras] == [(64, 48)] * 2
    np.testing.assert_allclose(capture.frame(1, 0).astype(int), upright, atol=3)


def test_poses_of_pictures_on_their_side_are_refused_with_the_cure(
    n3dv: Path, write_video: Callable[..., None]
) -> None:
    write_video(n3dv / "cam01.mp4", [20] * 6, size=(48, 64))
    with pytest.raises(InputError, match=r"the camera is for 64x48 pixels and the pictures have 48x64; .*upright"):
        open_capture(n3dv)


@pytest.mark.parametrize(("degrees", "mirrored"), [(0, True), (45, False)])
def test_other_matrices_are_refused(upright: Corners, tmp_path: Path, degrees: float, mirrored: bool) -> None:
    write(tmp_path / "cam00.mp4", upright, degrees, mirrored=mirrored)
    with pytest.raises(InputError, match=r"cam00\.mp4: the video is to be shown mirrored or tilted"):
        VideoReader(tmp_path / "cam00.mp4")
