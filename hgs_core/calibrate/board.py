"""A ChArUco board in the pictures: its corners, by camera and moment.

OpenCV finds the board; it is loaded when it is first needed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base.cores import core_pool
from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, ProgressCallback

__all__ = ["DICTIONARIES", "Board", "Sighting", "find_board", "open_cv"]

DICTIONARIES = tuple(f"{bits}X{bits}_{count}" for bits in (4, 5, 6, 7) for count in (50, 100, 250, 1000))
"""OpenCV's families of markers: bits along a side, and how many markers there are."""

_MOMENTS = 40  # moments searched for the board
_FEWEST_CORNERS = 6  # corners of a sighting

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Board:
    """A printed ChArUco board."""

    columns: int  # squares across
    rows: int  # squares down
    square: float  # metres, side of a square
    marker: float  # metres, side of a marker
    dictionary: str = "4X4_50"
    legacy: bool = False  # printed by OpenCV before 4.6, whose first square is white where rows are even

    def __post_init__(self) -> None:
        """Check every field.

        Raises:
            InputError: names the option, the value and the range.
        """
        if not (2 < self.columns < 100 and 2 < self.rows < 100):
            raise InputError("--board", f"{self.columns}x{self.rows} squares", "give 3 to 99 each way, as in 8x5")
        if not 0 < self.square < 100:
            raise InputError("--square", f"{self.square:g} is no length", "give the side of a square in metres")
        if not 0 < self.marker < self.square:
            raise InputError("--marker", f"{self.marker:g} is no side of a marker", "it is shorter than a square's")
        if self.dictionary not in DICTIONARIES:
            raise InputError("--dictionary", f"{self.dictionary!r} is unknown", f"one of {', '.join(DICTIONARIES)}")

    @property
    def corners(self) -> Floats:
        """The inner corners [N, 3], metres: x to the right, y down, and z, always 0, away from the viewer."""
        across, down = np.meshgrid(np.arange(1, self.columns), np.arange(1, self.rows))
        flat = np.stack([across.ravel(), down.ravel(), np.zeros(across.size)], axis=1)
        return np.asarray(flat * self.square)


@dataclass(frozen=True)
class Sighting:
    """The board as one camera sees it at one moment."""

    camera: int
    moment: int
    corners: npt.NDArray[np.int64]  # [N] which of the board's
    xy: Floats  # [N, 2] pixels, centres at +0.5


def find_board(
    board: Board,
    cameras: int,
    picture: Callable[[int, int], npt.NDArray[np.uint8]],  # [H, W, 3] of a camera and a frame
    frames: int,
    progress: ProgressCallback,
) -> list[Sighting]:
    """Return where the board is seen, at up to 40 moments spread over the frames, the same for all cameras.

    Raises:
        InputError: OpenCV is not installed.
    """
    open_cv()
    chosen = sorted({round(place) for place in np.linspace(0, frames - 1, min(frames, _MOMENTS))})

    def of_camera(camera: int) -> list[Sighting]:
        seen = []
        detector = _detector(board)
        for frame in chosen:
            corners, xy = _corners(detector, picture(camera, frame))
            if len(corners) >= _FEWEST_CORNERS and _spread(board, corners):
                seen.append(Sighting(camera, frame, corners, xy))
        return seen

    found: list[Sighting] = []
    with core_pool() as pool:
        for done, seen in enumerate(pool.map(of_camera, range(cameras)), 1):
            found += seen
            progress(Progress("board", done, cameras))
    return found


def open_cv() -> Any:
    """Return OpenCV.

    Raises:
        InputError: it is not installed; the message names the extra that has it.
    """
    try:
        import cv2
    except ImportError as error:
        raise InputError("--board", "OpenCV is not installed", "pip install 'hgs[board]'") from error
    return cv2


def _detector(board: Board) -> Any:
    aruco = open_cv().aruco
    family = aruco.getPredefinedDictionary(getattr(aruco, f"DICT_{board.dictionary}"))
    size = (board.columns, board.rows)
    pattern = aruco.CharucoBoard(size, board.square, board.marker, family)
    pattern.setLegacyPattern(board.legacy)
    return aruco.CharucoDetector(pattern)


def _corners(detector: Any, picture: Sequence[Any] | npt.NDArray[np.uint8]) -> tuple[npt.NDArray[np.int64], Floats]:
    grey = np.ascontiguousarray((np.asarray(picture) @ np.array([0.299, 0.587, 0.114])).round().astype(np.uint8))
    xy, identities, _, _ = detector.detectBoard(grey)
    if identities is None or xy is None:
        return np.zeros(0, np.int64), np.zeros((0, 2))
    # OpenCV counts pixels from the centre of the first one.
    return np.asarray(identities, np.int64).ravel(), np.asarray(xy, np.float64).reshape(-1, 2) + 0.5


def _spread(board: Board, corners: npt.NDArray[np.int64]) -> bool:
    """Whether the corners lie in more than one row and column: a line of them tells no pose."""
    rows, columns = np.divmod(corners, board.columns - 1)
    return len(set(rows.tolist())) > 1 and len(set(columns.tolist())) > 1
