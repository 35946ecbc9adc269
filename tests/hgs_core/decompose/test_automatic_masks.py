"""Automatic masks as they are found, segment by segment."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.progress import Progress, silent
from hgs_core.capture.capture import Capture
from hgs_core.decompose.automatic_masks import automatic_masks
from hgs_core.scene.camera import Camera

SHAPE = (20, 24)


class Footage:
    """A ramp of brightness on which a bright square moves; it counts the pictures asked for."""

    def __init__(self, broken: int = -1) -> None:
        self.asked: Counter[tuple[int, int]] = Counter()
        self.broken = broken

    def read(self, camera: int, frame: int, neighbours: int) -> tuple[np.ndarray, tuple[()]]:
        if frame == self.broken:
            raise OSError("broken")
        self.asked[camera, frame] += 1
        picture = np.repeat(np.linspace(50, 90, SHAPE[1], dtype=np.uint8)[None, :, None], SHAPE[0], 0).repeat(3, 2)
        picture[5:12, frame % 17 : frame % 17 + 6] = 220
        return picture, ()

    def read_mask(self, camera: int, frame: int) -> None:
        return None


def capture_of(footage: Footage, frames: int) -> Capture:
    cameras = [Camera(name, SHAPE[1], SHAPE[0], 20, 20, 12, 10, np.eye(4)) for name in "ab"]
    return Capture(Path("c"), cameras, np.arange(frames) / 30, footage, "one", cache_bytes=0)


def test_shared_frames_are_looked_at_once() -> None:
    footage = Footage()
    segments = [range(11), range(9, 21), range(19, 30)]
    found = list(automatic_masks(capture_of(footage, 30), [0, 1], segments, silent))
    assert [one.frames for one in found] == segments
    for frame in (9, 10, 19, 20):
        masks = [one.packed(1, frame) for one in found if frame in one.frames]
        assert masks[0] == masks[1]
    most = 25 * 2 + 30 * 2
    assert sum(footage.asked.values()) == most


def test_the_background_is_that_of_the_whole_capture() -> None:
    """The same masks come of a part as of all."""
    whole = next(automatic_masks(capture_of(Footage(), 30), [0], [range(30)], silent))
    part = next(automatic_masks(capture_of(Footage(), 30), [0], [range(12, 17)], silent))
    assert part.rows[0] == whole.rows[0][12:17]


def test_progress_rises_to_its_total_while_a_segment_is_made() -> None:
    reports: list[Progress] = []
    for _ in automatic_masks(capture_of(Footage(), 30), [0, 1], [range(16), range(14, 30)], reports.append):
        pass
    done = [report.done for report in reports]
    assert done == sorted(done)
    assert (done[0], done[-1]) == (0, 2 * (25 + 30))
    assert {report.total for report in reports} == {2 * (25 + 30)}


def test_a_picture_that_cannot_be_read_ends_it_at_once() -> None:
    footage = Footage(broken=4)
    segments = automatic_masks(capture_of(footage, 200), [0, 1], [range(200)], silent)
    with pytest.raises(OSError, match="broken"):
        next(segments)
    assert sum(footage.asked.values()) < 2 * 200
