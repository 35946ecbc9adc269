"""Whether a camera moved while it recorded."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hgs_core.points.features import Features, mutual_matches

__all__ = ["camera_shift"]

_FEWEST = 30  # matches
_STILL = 1.0  # pixels that a feature on something still may seem to move by
_STILL_SHARE = 0.25  # share of features at rest with which the camera stands still
_COHERENT_SHARE = 0.5  # share of features on one affine motion that make it the camera's
_ROUNDS = 20  # rounds of reweighting

Floats = npt.NDArray[np.float64]


def camera_shift(first: Features, last: Features) -> float | None:
    """Return by how many pixels the picture as a whole shifted between two moments, None if the camera stands still.

    A camera moves if its features leave their places together: what moves in front of it does so each for itself.
    """
    rows = mutual_matches(first, last)
    if len(rows) < _FEWEST:
        return None
    start, end = first.xy[rows[:, 0]], last.xy[rows[:, 1]]
    shift = np.linalg.norm(end - start, axis=1)
    if (shift < _STILL).mean() > _STILL_SHARE:
        return None
    if _share_on_one_motion(start, end) < _COHERENT_SHARE:
        return None
    return float(np.median(shift))


def _share_on_one_motion(start: Floats, end: Floats) -> float:
    """Return how many of the points follow one affine motion, fitted by reweighted least squares."""
    known = np.column_stack((start - start.mean(axis=0), np.ones(len(start))))
    weights = np.ones(len(start))
    scale = 50.0
    distance = np.zeros(len(start))
    for _ in range(_ROUNDS):
        scaled = known * weights[:, None]
        motion = np.linalg.lstsq(scaled.T @ known, scaled.T @ end, rcond=None)[0]
        distance = np.linalg.norm(known @ motion - end, axis=1)
        scale = max(1.0, scale / 2)
        weights = 1 / (1 + (distance / scale) ** 2) ** 2
    return float((distance < 2 * _STILL).mean())
