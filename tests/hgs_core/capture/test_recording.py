"""The capture of a recording: reduced pictures, masks, cameras and notes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.lenses.lens import PINHOLE, Polynomial, opencv_lens
from hgs_core.capture.lenses.straighten import StraightView
from hgs_core.capture.open import open_capture
from hgs_core.capture.pictures.mask_files import MaskFiles
from hgs_core.capture.recording import Recording
from hgs_core.capture.time.clock import Clock
from hgs_core.scene.camera import Camera
from tests.hgs_core.capture.conftest import write_masks

WHOLE = np.random.default_rng(0).integers(0, 256, (32, 64, 3)).astype(np.uint8)


class OnePicture:
    """The same picture for every frame, and half as bright in the frame after."""

    def read(self, index: int, neighbours: int) -> tuple[np.ndarray, list[tuple[int, np.ndarray]]]:
        return WHOLE, [(index + 1, WHOLE // 2)]


def recording(tmp_path: Path, **more: object) -> Recording:
    poses = tmp_path / "poses"
    poses.write_bytes(b"poses")
    camera = Camera("a", 64, 32, 50.0, 50.0, 32.0, 16.0, np.eye(4))
    given = {"views": [StraightView.of(camera, PINHOLE)], "clock": ticks(2), "masks": MaskFiles({})} | more
    return Recording(  # type: ignore[arg-type]
        tmp_path, readers=[OnePicture()], files=[(poses, 5)], described_by=[poses], **given
    )


def ticks(count: int, *own: int) -> Clock:
    """A clock of one camera, which shows its frames in order or those of the numbers given."""
    times = np.arange(count) / 30
    return Clock(times, np.array([own or range(count)], np.int64), times[None])


def test_a_picture_and_its_neighbours_are_reduced_to_the_means_of_areas(tmp_path: Path) -> None:
    half = recording(tmp_path).capture(downscale=2, cache_bytes=1 << 20)
    for frame, whole in ((0, WHOLE), (1, WHOLE // 2)):
        means = whole.reshape(16, 2, 32, 2, 3).mean(axis=(1, 3))
        assert np.abs(half.frame(0, frame) - means).max() <= 1.0  # each axis rounds once


def test_a_whole_capture_has_the_pictures_as_they_are(tmp_path: Path) -> None:
    np.testing.assert_array_equal(recording(tmp_path).capture(downscale=1, cache_bytes=0).frame(0, 0), WHOLE)


def test_a_reduced_capture_is_another_one_by_its_fingerprint(tmp_path: Path) -> None:
    found = [recording(tmp_path).capture(downscale=k, cache_bytes=0).fingerprint() for k in (1, 2, 2)]
    assert found[1] == found[2] != found[0]


def test_frames_are_those_of_the_clock_and_neighbours_too(tmp_path: Path) -> None:
    """Frames 0, 2 and 3 of the camera are shown: of 2 the neighbour is 3, of 0 it is none."""
    capture = recording(tmp_path, clock=ticks(3, 0, 2, 3)).capture(downscale=1, cache_bytes=1 << 20)
    assert [capture.number(0, frame) for frame in range(3)] == [0, 2, 3]
    for frame in (0, 1):
        np.testing.assert_array_equal(capture.frame(0, frame), WHOLE)
    np.testing.assert_array_equal(capture.frame(0, 2), WHOLE // 2)  # it was passed on the way


def test_pictures_and_masks_are_straightened(tmp_path: Path) -> None:
    folder = write_masks(tmp_path / "masks" / "cam00", frames=[0, 5], size=(64, 32))
    masks = MaskFiles({"a": {0: folder / "cam00" / "00000.png", 1: folder / "cam00" / "00005.png"}}, folder)
    lens = opencv_lens([-0.2], False)
    view = StraightView.of(Camera("a", 64, 32, 50.0, 50.0, 32.0, 16.0, np.eye(4)), lens)
    capture = recording(tmp_path, views=[view], masks=masks).capture(downscale=1, cache_bytes=0)
    np.testing.assert_array_equal(capture.frame(0, 0), view.straightened(WHOLE))
    mask = capture.mask(0, 1)
    assert mask is not None
    assert mask.shape == capture.frame(0, 0).shape[:2] == (view.camera.height, view.camera.width)
    assert mask.any()


def test_lines_are_those_of_the_file_neither_straightened_nor_reduced(tmp_path: Path) -> None:
    view = StraightView.of(Camera("a", 64, 32, 50.0, 50.0, 32.0, 16.0, np.eye(4)), opencv_lens([-0.2], False))
    capture = recording(tmp_path, views=[view], clock=ticks(1, 4)).capture(downscale=2, cache_bytes=1 << 20)
    np.testing.assert_array_equal(capture.lines(0, 0), WHOLE[..., 1])
    with pytest.raises(IndexError):
        capture.lines(0, 1)


def test_what_a_straight_picture_cannot_show_is_said(tmp_path: Path) -> None:
    wide = Camera("a", 64, 32, 20.0, 20.0, 32.0, 16.0, np.eye(4))  # 91 degrees to either side
    view = StraightView.of(wide, Polynomial(fisheye=True))
    capture = recording(tmp_path, views=[view]).capture(downscale=1, cache_bytes=0)
    assert capture.notes == ("straight pictures end 60 degrees from the axis; a sees farther",)


def test_at_one_moment_masks_are_not_used_and_a_note_says_so(tmp_path: Path) -> None:
    folder = write_masks(tmp_path / "masks" / "cam00", frames=range(1), size=(64, 32))
    masks = MaskFiles({"a": {0: folder / "cam00" / "00000.png"}}, folder)
    capture = recording(tmp_path, clock=ticks(1), masks=masks, notes=("one is gone",)).capture(
        downscale=1, cache_bytes=0
    )
    assert capture.mask(0, 0) is None
    assert capture.notes == ("one is gone", "the masks are not used: at one moment nothing moves")


def test_reduced_captures_reduce_pictures_masks_and_cameras_alike(n3dv: Path) -> None:
    write_masks(n3dv / "masks" / "cam00")
    whole, half = open_capture(n3dv), open_capture(n3dv, downscale=2)
    mask, picture = half.mask(0, 3), half.frame(0, 3)
    assert mask is not None
    assert picture.shape == (24, 32, 3)
    assert np.unique(np.argwhere(mask)[:, 1]).tolist() == [4, 5]  # columns 8 to 10: a part of a pixel is enough
    point = np.array([[0.2, 0.1, 2.0]])
    np.testing.assert_allclose(half.cameras[0].project(point)[0], whole.cameras[0].project(point)[0] / 2)
    assert half.fingerprint() != whole.fingerprint()


@pytest.mark.parametrize(("factor", "problem"), [(0, "0 is too small"), (4, "4 is too much for the 64x48 pictures")])
def test_senseless_reductions_are_refused(n3dv: Path, factor: int, problem: str) -> None:
    with pytest.raises(InputError, match=f"downscale: {problem}"):
        open_capture(n3dv, downscale=factor)


def test_one_camera_can_be_reduced_more_than_the_others(n3dv: Path) -> None:
    names = [camera.name for camera in open_capture(n3dv).cameras]
    capture = open_capture(n3dv, reductions={names[1]: 2})
    assert [camera.width for camera in capture.cameras[:2]] == [64, 32]
    assert capture.frame(1, 0).shape == (24, 32, 3)
    assert capture.fingerprint() != open_capture(n3dv).fingerprint()
    with pytest.raises(InputError, match="there is no camera 'gone'"):
        open_capture(n3dv, reductions={"gone": 2})
