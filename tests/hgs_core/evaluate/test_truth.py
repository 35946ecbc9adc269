from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from hgs_core.base.errors import InputError
from hgs_core.capture.open import open_capture
from hgs_core.evaluate.truth import Truth
from tests.hgs_core.evaluate.conftest import FRAMES, SIZE, save
from tests.synthetic import write_capture


@pytest.fixture
def pictures(tmp_path: Path) -> Path:
    """Pictures of camera 2, frame f all of the value 50 f, without leading zeros in their names."""
    for frame in range(FRAMES):
        save(np.full((*SIZE, 3), 50 * frame, np.uint8), tmp_path / "truth" / "2" / f"{frame}.png")
    return tmp_path / "truth"


def test_without_folders_the_capture_is_the_truth(capture_folder: Path) -> None:
    capture = open_capture(capture_folder)
    truth = Truth(capture, [2], pictures=None, masks=None, downscale=1)
    expected = torch.tensor(np.array(capture.frame(2, 1))).permute(2, 0, 1) / 255
    assert torch.equal(truth.picture(2, 1), expected)
    assert (truth.of_pictures, truth.of_masks) == ("capture", "automatic")


def test_without_masks_they_are_made_of_the_true_pictures(tmp_path: Path) -> None:
    """A square passes over a still wall; the capture's pictures differ from the truth and show no motion."""
    write_capture(tmp_path / "capture", frames=8, width=SIZE[1], height=SIZE[0])
    wall = np.random.default_rng(0).integers(60, 90, (*SIZE, 3), np.uint8)
    for frame in range(8):
        picture = wall.copy()
        picture[16:32, 8 * frame : 8 * frame + 8] = 250
        save(picture, tmp_path / "truth" / "2" / f"{frame:04d}.png")
    truth = Truth(open_capture(tmp_path / "capture"), [2], pictures=tmp_path / "truth", masks=None, downscale=1)
    assert truth.of_masks == "automatic"
    for frame in (1, 6):
        moving = truth.moving(2, frame)
        assert moving is not None
        assert moving[18:30, 8 * frame + 1 : 8 * frame + 7].all()
        moving[8:40, max(0, 8 * frame - 8) : 8 * frame + 16] = False
        assert not moving.any()


def test_at_a_single_moment_nothing_moves(tmp_path: Path) -> None:
    write_capture(tmp_path / "capture", frames=1, width=SIZE[1], height=SIZE[0])
    truth = Truth(open_capture(tmp_path / "capture"), [2], pictures=None, masks=None, downscale=1)
    assert (truth.of_masks, truth.moving(2, 0)) == (None, None)


def test_the_captures_own_masks_are_used_unless_others_are_given(capture_folder: Path, masks_folder: Path) -> None:
    capture = open_capture(capture_folder, masks=masks_folder)
    own = Truth(capture, [1, 2], pictures=None, masks=None, downscale=1)
    assert own.moving(1, 2) is None
    moving = own.moving(2, 2)
    assert moving is not None
    assert moving.sum() == 2 * SIZE[0]
    assert own.of_masks == "capture"
    save(np.full(SIZE, 255, np.uint8), masks_folder.parent / "other" / "2" / "0000.png")
    for frame in range(1, FRAMES):
        save(np.zeros(SIZE, np.uint8), masks_folder.parent / "other" / "2" / f"{frame:04d}.png")
    given = Truth(capture, [2], pictures=None, masks=masks_folder.parent / "other", downscale=1)
    assert [int(m.sum()) for frame in range(FRAMES) if (m := given.moving(2, frame)) is not None] == [48 * 64, 0, 0]
    assert given.of_masks == "given"


def test_files_are_numbered_from_the_first_frame(capture_folder: Path, pictures: Path) -> None:
    truth = Truth(open_capture(capture_folder), [2], pictures=pictures, masks=None, downscale=1)
    for frame in range(FRAMES):
        assert torch.equal(truth.picture(2, frame), torch.full((3, *SIZE), 50 * frame / 255))
    assert truth.of_pictures == "given"


def test_a_reduced_run_takes_files_of_the_whole_or_of_the_reduced_size(
    capture_folder: Path, pictures: Path, masks_folder: Path
) -> None:
    capture = open_capture(capture_folder, downscale=2)
    whole = Truth(capture, [2], pictures=pictures, masks=masks_folder, downscale=2)
    assert torch.equal(whole.picture(2, 1), torch.full((3, 24, 32), 50 / 255))
    moving = whole.moving(2, 1)
    assert moving is not None
    assert moving.shape == (24, 32)
    assert moving.sum() == 24  # a pixel moves if any part of it does
    for frame in range(FRAMES):
        save(np.zeros((24, 32, 3), np.uint8), pictures.parent / "small" / "2" / f"{frame:04d}.png")
    small = Truth(capture, [2], pictures=pictures.parent / "small", masks=None, downscale=2)
    assert small.picture(2, 0).shape == (3, 24, 32)


@pytest.mark.parametrize(
    ("damage", "problem"),
    [
        ("no folder", "is not a folder"),
        ("no camera", "no pictures of camera 2.*--cameras"),
        ("from one", r"picture of frame 0 is missing; there are 3 frames, numbered from 0000\.png"),
        ("size", r"1\.png: the picture is 10x20"),
        ("garbage", r"1\.png: the picture is unreadable"),
    ],
)
def test_wrong_folders_are_refused_before_scoring(
    capture_folder: Path, pictures: Path, damage: str, problem: str
) -> None:
    if damage == "no folder":
        pictures = pictures / "absent"
    elif damage == "no camera":
        (pictures / "2").rename(pictures / "3")
    elif damage == "from one":
        (pictures / "2" / "0.png").rename(pictures / "2" / "3.png")
    elif damage == "size":
        save(np.zeros((20, 10, 3), np.uint8), pictures / "2" / "1.png")
    else:
        (pictures / "2" / "1.png").write_bytes(b"no picture")
    with pytest.raises(InputError, match=problem):
        Truth(open_capture(capture_folder), [2], pictures=pictures, masks=None, downscale=1)
