"""Offsets of shifted videos, and which of both ways is believed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from hgs_core.capture.capture import Capture
from hgs_core.check import synchronise
from hgs_core.check.synchronise import find_offsets


@dataclass
class Shifted:
    """The capture with other first frames, 40 frames long."""

    capture: Capture
    shifts: tuple[int, ...]

    @property
    def path(self) -> Path:
        return self.capture.path

    @property
    def cameras(self) -> object:
        return self.capture.cameras

    @property
    def times(self) -> np.ndarray:
        return np.arange(40) / 30

    def frame(self, camera: int, frame: int) -> np.ndarray:
        return self.capture.frame(camera, frame + 7 + self.shifts[camera])


@pytest.mark.slow
def test_shifted_videos_are_told_apart_to_half_a_frame(studio: Capture) -> None:
    shifts = (0, 5, -7, 0, 3)
    found = find_offsets(Shifted(studio, shifts), lambda progress: None)  # type: ignore[arg-type]
    off = np.array([offset for offset in found if offset is not None]) - shifts
    assert len(off) == 5
    np.testing.assert_allclose(off, np.median(off), atol=0.5)


def test_of_a_short_capture_nothing_is_told(studio: Capture) -> None:
    class Short(Shifted):
        times = np.arange(29) / 30

    assert find_offsets(Short(studio, (0,) * 5), lambda progress: None) == [None] * 5  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("energy", "features", "believed"),
    [
        ([0.0, 3.1, None], [0.1, 3.0, 1.5], [0.1, 3.0, 1.5]),  # features refine and add
        ([0.0, 3.1, 1.0], [0.1, -4.0, 1.2], [0.1, 3.1, 1.2]),  # one is chance
        ([0.0, 3.1, 5.0], [0.1, -4.0, 1.2], [0.1, -4.0, 1.2]),  # energy is
        ([0.0, 3.1, 5.0], [None, None, 1.2], [0.0, 3.1, 5.0]),  # features know too little
        ([None, None, None], [0.1, 3.0, 1.5], [0.1, 3.0, 1.5]),
    ],
)
def test_the_way_that_knows_is_believed(
    energy: list[float | None], features: list[float | None], believed: list[float | None]
) -> None:
    assert synchronise._agreed(energy, features) == believed
