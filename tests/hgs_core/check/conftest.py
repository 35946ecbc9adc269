"""Small captures of real pictures: some of the videos of samples/studio, with poses that a test may spoil."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from hgs_core.capture.capture import Capture
from hgs_core.capture.open import open_capture
from hgs_core.check.evidence import Evidence, gather
from tests.conftest import REPOSITORY

STUDIO = REPOSITORY / "samples" / "studio"
NUMBERS = (0, 4, 6, 12, 14)

Spoil = Callable[[npt.NDArray[np.float64]], None]


def write_studio(folder: Path, spoil: Spoil | None = None) -> Path:
    """Link five videos into `folder` and write their poses, rows of poses_bounds.npy, as `spoil` leaves them."""
    folder.mkdir()
    for number in NUMBERS:
        (folder / f"cam{number:02d}.mp4").symlink_to(STUDIO / f"cam{number:02d}.mp4")
    poses = np.load(STUDIO / "poses_bounds.npy")[list(NUMBERS)]
    if spoil is not None:
        spoil(poses)
    np.save(folder / "poses_bounds.npy", poses)
    return folder


@pytest.fixture
def studio_with(tmp_path: Path) -> Callable[[Spoil | None], Capture]:
    """Return a function that opens the five cameras with poses changed in place."""
    return lambda spoil=None: open_capture(write_studio(tmp_path / "studio", spoil))


@pytest.fixture(scope="session")
def studio(tmp_path_factory: pytest.TempPathFactory) -> Capture:
    return open_capture(write_studio(tmp_path_factory.mktemp("good") / "studio"))


@pytest.fixture(scope="session")
def studio_evidence(studio: Capture) -> Evidence:
    return gather(studio, lambda progress: None, followed=True)
