"""Pictures of one moment, and of the room without movers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.progress import silent
from hgs_core.capture.capture import Capture
from hgs_core.capture.open import open_capture
from hgs_core.decompose.masks import MotionMasks, motion_masks
from hgs_core.points.pictures_of_moments import seen_at, still_pictures
from hgs_core.points.same_moment import SameMoment
from tests.walking_body import write_walk

VIEWS = (0, 2)


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Capture:
    folder: Path = tmp_path_factory.mktemp("walk")
    write_walk(folder, 3)
    return open_capture(folder)


@pytest.fixture(scope="module")
def masks(capture: Capture) -> MotionMasks:
    return motion_masks(capture, VIEWS, progress=silent)


def test_a_moment_has_the_pictures_and_masks_of_its_own_frames(capture: Capture, masks: MotionMasks) -> None:
    views, pictures, moving = seen_at(capture, SameMoment(0.0, (2, 0), (1, 2)), masks)
    assert [view.name for view in views] == ["2", "0"]
    np.testing.assert_array_equal(pictures[0], capture.frame(2, 1))
    np.testing.assert_array_equal(moving[1], masks.mask(0, 2))


def test_still_pictures_are_medians_and_trusted_where_little_moves(capture: Capture, masks: MotionMasks) -> None:
    for index, (picture, trusted) in zip(VIEWS, still_pictures(capture, masks, VIEWS), strict=True):
        frames = np.stack([capture.frame(index, frame) for frame in range(3)])
        moving = np.stack([masks.mask(index, frame) for frame in range(3)])
        np.testing.assert_array_equal(trusted, moving.mean(0) < 0.5)
        np.testing.assert_array_equal(picture[~moving.any(0)], frames[0][~moving.any(0)])
