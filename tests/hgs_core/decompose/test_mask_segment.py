"""The file of a segment's masks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.decompose.mask_segment import MaskSegment, packed_mask


def segment_of(masks: np.ndarray) -> MaskSegment:
    """Masks [2, F, H, W] of cameras 0 and 3, from frame 7 on."""
    rows = {camera: [packed_mask(mask) for mask in own] for camera, own in zip((0, 3), masks, strict=True)}
    return MaskSegment(range(7, 7 + masks.shape[1]), rows)


@pytest.fixture
def masks() -> np.ndarray:
    return np.random.default_rng(0).random((2, 4, 5, 9)) < 0.3


def test_a_file_gives_the_masks_that_were_saved(masks: np.ndarray, tmp_path: Path) -> None:
    segment_of(masks).save(tmp_path / "0.masks", "one")
    loaded = MaskSegment.load(tmp_path / "0.masks", "one")
    assert loaded.frames == range(7, 11)
    for place, camera in enumerate((0, 3)):
        for frame in range(4):
            np.testing.assert_array_equal(loaded.mask(camera, 7 + frame, (5, 9)), masks[place, frame])


def test_a_frame_or_camera_that_it_lacks_is_not_another_s(masks: np.ndarray) -> None:
    with pytest.raises(ValueError, match="11 is not in range"):
        segment_of(masks).packed(0, 11)
    with pytest.raises(KeyError):
        segment_of(masks).packed(1, 7)


def test_a_segment_without_automatic_masks_has_a_file_too(tmp_path: Path) -> None:
    MaskSegment(range(3), {}).save(tmp_path / "0.masks", "one")
    assert MaskSegment.load(tmp_path / "0.masks", "one") == MaskSegment(range(3), {})


@pytest.mark.parametrize(
    ("damage", "problem"),
    [
        (lambda whole: b"", "no readable masks"),
        (lambda whole: b"[1, 2]\n", "no readable masks"),
        (lambda whole: whole[:-1], "the masks are incomplete"),
        (lambda whole: whole + b" ", "the masks are incomplete"),
        (lambda whole: whole.replace(b'"frames":4', b'"frames":3'), "the masks are incomplete"),
        (lambda whole: whole.replace(b'"one"', b'"two"'), "another state of the capture"),
    ],
)
def test_a_damaged_file_is_refused(masks: np.ndarray, tmp_path: Path, damage: object, problem: str) -> None:
    assert callable(damage)
    path = tmp_path / "0.masks"
    segment_of(masks).save(path, "one")
    path.write_bytes(damage(path.read_bytes()))
    with pytest.raises(InputError, match=problem):
        MaskSegment.load(path, "one")
