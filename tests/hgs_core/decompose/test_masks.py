"""Masks of a whole capture: given and automatic, held as bits, saved and loaded."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, StageStopped, silent
from hgs_core.capture.capture import Capture
from hgs_core.decompose.masks import MotionMasks, kept_masks, mask_file, motion_masks
from hgs_core.scene.camera import Camera

FRAMES = 8
STARTS = (0, 3, 6)  # first frames of segments


class MovingBar:
    """Three views of a grey room, where a bright bar moves by five pixels a frame. The last view has given masks."""

    def __init__(self) -> None:
        self.asked: set[int] = set()
        self.masks_read = 0

    def read(self, camera: int, frame: int, neighbours: int) -> tuple[np.ndarray, tuple[()]]:
        self.asked.add(camera)
        picture = np.full((40, 53, 3), 90, np.uint8)
        picture[:, 5 * frame : 5 * frame + 8] = 220
        return picture, ()

    def read_mask(self, camera: int, frame: int) -> np.ndarray | None:
        if camera < 2:
            return None
        self.masks_read += 1
        mask = np.zeros((40, 53), bool)
        mask[:, 5 * frame : 5 * frame + 8] = True
        return mask


def bar_capture(fingerprint: str = "one") -> tuple[Capture, MovingBar]:
    source = MovingBar()
    cameras = [Camera(name, 53, 40, 50, 50, 26.5, 20, np.eye(4)) for name in "abc"]
    return Capture(Path("bar"), cameras, np.arange(FRAMES) / 30, source, fingerprint, cache_bytes=1 << 22), source


@pytest.mark.parametrize("camera", [0, 1, 2])
def test_given_and_automatic_masks_find_the_bar(camera: int) -> None:
    masks = motion_masks(bar_capture()[0], [0, 1, 2], progress=silent)
    for frame in range(FRAMES):
        mask = masks.mask(camera, frame)
        assert mask.shape == (40, 53)
        assert mask.dtype == np.bool_
        assert mask[:, 5 * frame : 5 * frame + 8].mean() > 0.99
        assert mask.mean() < 0.35


def test_other_cameras_are_not_read() -> None:
    capture, source = bar_capture()
    masks = motion_masks(capture, [1], progress=silent)
    assert source.asked == {1}
    with pytest.raises(IndexError):
        masks.mask(0, 0)


def test_a_given_mask_is_read_once() -> None:
    capture, source = bar_capture()
    masks = motion_masks(capture, [2], progress=silent)
    before = source.masks_read
    first = masks.mask(2, 3)
    np.testing.assert_array_equal(first, masks.mask(2, 3))
    assert source.masks_read == before + 1


def test_share_is_the_mean_of_the_masks() -> None:
    capture, _ = bar_capture()
    masks = motion_masks(capture, [0, 2], progress=silent)
    mean = np.mean([masks.mask(camera, frame).mean() for camera in (0, 2) for frame in range(FRAMES)])
    assert masks.share() == pytest.approx(float(mean))


def test_saved_masks_come_back(tmp_path: Path) -> None:
    capture, _ = bar_capture()
    masks = motion_masks(capture, [0, 2], progress=silent)
    masks.save(tmp_path, STARTS)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["0.masks", "1.masks", "2.masks"]
    loaded = MotionMasks.load(tmp_path, capture, (0, 2), STARTS)
    for camera in (0, 2):
        for frame in range(FRAMES):
            np.testing.assert_array_equal(loaded.mask(camera, frame), masks.mask(camera, frame))


def test_masks_of_another_capture_are_refused(tmp_path: Path) -> None:
    motion_masks(bar_capture()[0], [0], progress=silent).save(tmp_path, STARTS)
    with pytest.raises(InputError, match=r"1\.masks: the masks belong to another state"):
        MotionMasks.load(tmp_path, bar_capture("two")[0], [0], STARTS).mask(0, 4)


@pytest.mark.parametrize(("length", "problem"), [(0, "no readable"), (50, "no readable"), (150, "incomplete")])
def test_truncated_masks_are_refused(tmp_path: Path, length: int, problem: str) -> None:
    capture, _ = bar_capture()
    motion_masks(capture, [0], progress=silent).save(tmp_path, [0])
    path = mask_file(tmp_path, 0)
    path.write_bytes(path.read_bytes()[:length])
    with pytest.raises(InputError, match=rf"0\.masks: .*{problem}"):
        MotionMasks.load(tmp_path, capture, [0], [0]).mask(0, 0)


def test_a_segment_needs_its_own_file_alone(tmp_path: Path) -> None:
    """Cameras out of step take a picture from either side of it."""
    capture, _ = bar_capture()
    masks = motion_masks(capture, [0], progress=silent)
    masks.save(tmp_path, STARTS)
    for number in (0, 2):
        mask_file(tmp_path, number).unlink()
    loaded = MotionMasks.load(tmp_path, capture, [0], STARTS)
    for frame in range(2, 7):
        np.testing.assert_array_equal(loaded.mask(0, frame), masks.mask(0, frame))
    for frame in (1, 7):
        with pytest.raises(InputError, match="no readable masks"):
            loaded.mask(0, frame)


def test_masks_are_kept_segment_by_segment(tmp_path: Path) -> None:
    """One that is stopped loses the segment that it is at, and goes on to the same bits."""
    whole, other = tmp_path / "whole", tmp_path / "other"
    kept_masks(whole, bar_capture()[0], [0, 1], STARTS, progress=silent)
    files = [mask_file(other, number) for number in range(3)]

    def stop(progress: Progress) -> None:
        if files[0].exists():
            raise StageStopped

    with pytest.raises(StageStopped):
        kept_masks(other, bar_capture()[0], [0, 1], STARTS, progress=stop)
    assert [file.exists() for file in files] == [True, False, False]
    reports: list[Progress] = []
    kept_masks(other, bar_capture()[0], [0, 1], STARTS, progress=reports.append)
    assert (reports[0].done, reports[-1].done, reports[-1].total) == (2 * 2, 2 * 16, 2 * 16)
    for number, file in enumerate(files):
        assert file.read_bytes() == mask_file(whole, number).read_bytes()


def test_what_is_there_is_kept_and_no_picture_is_read_again(tmp_path: Path) -> None:
    kept_masks(tmp_path, bar_capture()[0], [0, 1], STARTS, progress=silent)
    capture, source = bar_capture()
    kept_masks(tmp_path, capture, [0, 1], STARTS, progress=silent)
    assert source.asked == set()


def test_masks_of_segments_are_those_of_the_whole(tmp_path: Path) -> None:
    masks = motion_masks(bar_capture()[0], [0, 1], progress=silent)
    kept = kept_masks(tmp_path, bar_capture()[0], [0, 1], STARTS, progress=silent)
    for camera in (0, 1):
        for frame in range(FRAMES):
            np.testing.assert_array_equal(kept.mask(camera, frame), masks.mask(camera, frame))


def test_progress_counts_pictures_and_can_stop() -> None:
    reports: list[Progress] = []
    motion_masks(bar_capture()[0], [0, 1, 2], progress=reports.append)
    assert (reports[0].done, reports[-1].done) == (0, 2 * 16)  # each picture for the background, and for its mask
    assert {report.total for report in reports} == {2 * 16}

    def stop(progress: Progress) -> None:
        if progress.done:
            raise StageStopped

    with pytest.raises(StageStopped):
        motion_masks(bar_capture()[0], [0, 1], progress=stop)


def test_real_capture_has_given_masks(test_data: Callable[[str], Path]) -> None:
    from hgs_core.capture.open import open_capture

    capture = open_capture(test_data("panoptic_basketball"))
    masks = motion_masks(capture, [0, 1], progress=silent)
    assert 0.03 < masks.share() < 0.2


def test_nothing_moves_at_one_moment_and_no_picture_is_read() -> None:
    source = MovingBar()
    cameras = [Camera(name, 53, 40, 50, 50, 26.5, 20, np.eye(4)) for name in "ab"]
    capture = Capture(Path("bar"), cameras, np.zeros(1), source, "one", cache_bytes=1 << 22)
    masks = motion_masks(capture, [0, 1], progress=silent)
    assert not masks.mask(1, 0).any()
    assert source.asked == set()
