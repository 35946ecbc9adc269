from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hgs_core.check.given_masks import MaskEvidence, judge_masks, mask_evidence

NAMES = ["a", "b", "c", "d"]
GOOD = MaskEvidence((0.04, 0.05), moving=0.05, of_moving=0.66, of_still=0.01, above_half=0.04)
SHAPE = (48, 64)


class Masked:
    """A capture of one camera, with masks in files."""

    def __init__(self, folder: Path, masks: list[np.ndarray], suffix: str = ".png") -> None:
        self.files = [folder / f"{frame}{suffix}" for frame in range(len(masks))]
        for file, mask in zip(self.files, masks, strict=True):
            Image.fromarray(mask).save(file)

    def mask(self, camera: int, frame: int) -> np.ndarray:
        return np.asarray(Image.open(self.files[frame])) > 0

    def mask_file(self, camera: int, frame: int) -> Path:
        return self.files[frame]


def motion() -> list[np.ndarray]:
    moving = np.zeros((2, *SHAPE), bool)
    moving[0, 11:29, 10:21] = moving[1, 11:29, 30:41] = True
    return list(moving)


def measured(folder: Path, levels: list[np.ndarray]) -> MaskEvidence:
    evidence = mask_evidence(Masked(folder, levels), 0, range(2), motion())  # type: ignore[arg-type]
    assert evidence is not None
    return evidence


def test_masks_are_compared_with_what_moves(tmp_path: Path) -> None:
    evidence = measured(tmp_path, [255 * one.astype(np.uint8) for one in motion()])
    assert (evidence.of_moving, evidence.of_still, evidence.darkest, evidence.shades) == (1, 0, 0, 2)
    assert judge_masks(["a"], [evidence]) == []


@pytest.mark.parametrize(
    ("levels", "words"),
    [
        (lambda moving: np.where(moving, 0, 255), "inverted: they mark 100% of the pixels that stand still"),
        (lambda moving: np.where(moving, 255, 1), "darkest level of the masks is 1"),
        (lambda moving: np.where(moving, 7, 3), "darkest level of the masks is 3"),
        (lambda moving: np.full(moving.shape, 255), "mark 100 %"),
        (lambda moving: np.where(np.roll(moving, 20, axis=0), 255, 0), "mark 0% of the pixels that move"),
    ],
)
def test_wrong_masks_are_named(tmp_path: Path, levels: object, words: str) -> None:
    wrong = [levels(moving).astype(np.uint8) for moving in motion()]  # type: ignore[operator]
    (finding,) = judge_masks(["a"], [measured(tmp_path, wrong)])
    assert words in finding.problem


def test_the_cure_changes_the_masks_of_the_cameras_that_are_wrong_and_no_others(tmp_path: Path) -> None:
    wrong = []
    for camera, suffix in (("c 1", ".png"), ("c2", ".PNG")):
        (tmp_path / camera).mkdir()
        masked = Masked(tmp_path / camera, [np.where(one, 0, 255).astype(np.uint8) for one in motion()], suffix)
        wrong.append(mask_evidence(masked, 0, range(2), motion()))  # type: ignore[arg-type]
    (finding,) = judge_masks(NAMES, [GOOD, wrong[0], GOOD, wrong[1]])
    assert finding.cure.startswith(f"mogrify -negate '{tmp_path}/c 1'/*.png {tmp_path}/c2/*.PNG (")
    (finding,) = judge_masks(["c 1"], wrong[:1])
    assert finding.cure.startswith(f"mogrify -negate {tmp_path}/*/*.png (")


@pytest.mark.parametrize("levels", [lambda moving: np.where(moving, 1, 0), lambda moving: 3 * moving])
def test_numbers_of_objects_are_masks(tmp_path: Path, levels: object) -> None:
    numbered = [levels(moving).astype(np.uint8) for moving in motion()]  # type: ignore[operator]
    assert judge_masks(["a"], [measured(tmp_path, numbered)]) == []


def test_masks_that_went_through_jpeg_are_named(tmp_path: Path) -> None:
    soft = []
    for number, moving in enumerate(motion()):
        Image.fromarray(255 * moving.astype(np.uint8)).save(tmp_path / f"{number}.jpg", quality=30)
        soft.append(np.asarray(Image.open(tmp_path / f"{number}.jpg")))
    (finding,) = judge_masks(["a"], [measured(tmp_path, soft)])
    assert "as after JPEG" in finding.problem
    assert "-threshold 50%" in finding.cure


def test_masks_that_mark_nothing_anywhere_are_reported() -> None:
    empty = MaskEvidence((0.0, 0.0), shades=1)
    (finding,) = judge_masks(NAMES, [empty] * 4)
    assert "mark nothing" in finding.problem
    assert judge_masks(NAMES, [empty, GOOD, None, None]) == []


def test_only_the_cameras_with_wrong_masks_are_named() -> None:
    everything = MaskEvidence((1.0, 1.0), moving=0.05, of_moving=1, of_still=1, shades=1, darkest=255)
    (finding,) = judge_masks(NAMES, [GOOD, everything, GOOD, GOOD])
    assert finding.cameras == ("b",)


def test_where_next_to_nothing_moves_masks_are_not_judged_by_it() -> None:
    assert judge_masks(["a"], [MaskEvidence((0.9, 0.9), moving=0.001, of_moving=0, of_still=0.9)]) == []


def test_a_person_who_fills_the_picture_may_be_marked() -> None:
    assert judge_masks(["a"], [MaskEvidence((0.8, 0.8), moving=0.6, of_moving=0.9, of_still=0.7)]) == []
