"""Which points move: the verdict of the views that see them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.capture.capture import Capture
from hgs_core.capture.visibility import pixels_inside
from hgs_core.decompose.masks import MotionMasks

__all__ = ["label_points"]


def label_points(
    capture: Capture,
    masks: MotionMasks,
    cameras: Sequence[int],
    frame: int,
    xyz: npt.NDArray[np.floating[Any]],  # [P, 3] points seen at this frame
    seen: npt.NDArray[np.bool_] | None = None,  # [P, C] views that see each point; None: all whose picture it falls in
) -> npt.NDArray[np.float32]:
    """Return [P] the share of the views that see a point whose mask says that it moves, 0..1; 0 if no view sees it."""
    votes = np.zeros(len(xyz), np.float32)
    views = np.zeros(len(xyz), np.float32)
    for column, index in enumerate(cameras):
        rows, pixels = pixels_inside(capture.cameras[index], xyz)
        if seen is not None:
            kept = seen[rows, column]
            rows, pixels = rows[kept], pixels[kept]
        views[rows] += 1
        votes[rows] += masks.mask(index, frame)[pixels[:, 1], pixels[:, 0]]
    return np.asarray(votes / np.maximum(views, 1), np.float32)
