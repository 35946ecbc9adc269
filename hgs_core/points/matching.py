"""Matches between cameras with unknown or doubtful poses: features of several moments, joined.

Cameras far apart see little of one moment alike. What moves stands elsewhere in every frame, so features of several
moments, each matched within its moment alone, are a calibration target that the scene brings along.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import numpy.typing as npt

from hgs_core.points.features import Features, mutual_matches

__all__ = ["LONGEST_SIDE", "PairMatches", "likely_pairs", "match_moments", "moving_pixels"]

LONGEST_SIDE = 1000
"""Pixels: pictures with a longer side are reduced by a whole factor before features are looked for."""

_ALL_PAIRS = 12  # cameras up to which every pair is matched
_PARTNERS = 9  # further partners of a camera: those with most coarse matches
_COARSE = 600  # features that this is judged by
_FEWEST_COARSE = 8  # matches among them; fewer are chance
_CHANGE = 12.0  # levels from the median of all moments, beyond noise
_MAX_ERROR = 1.5  # pixels from the epipolar line
_TRIALS = 3000  # seven matches of 40 % on the geometry are right once in 600
_FEWEST = 25  # matches on one geometry
_LEAST_SHARE = 0.4  # share of a pair's matches on that geometry; chance gives less


@dataclass(frozen=True)
class PairMatches:
    """M matches of two cameras that agree with some epipolar geometry, apart from the cameras' poses."""

    rows: npt.NDArray[np.uint32]  # [M, 2] among the features of all moments, one moment after the other
    first: npt.NDArray[np.float64]  # [M, 2] pixels
    second: npt.NDArray[np.float64]  # [M, 2]
    moments: npt.NDArray[np.int64]  # [M]


def moving_pixels(pictures: Sequence[npt.NDArray[np.uint8]]) -> list[npt.NDArray[np.bool_]]:
    """Return for pictures [H, W, 3] of one camera, of different moments, where each differs from their median."""
    grey = np.stack([picture.mean(axis=2, dtype=np.float32) for picture in pictures])
    return list(np.abs(grey - np.median(grey, axis=0)) > _CHANGE)


def likely_pairs(features: Sequence[Sequence[Features]]) -> list[tuple[int, int]]:
    """Return the pairs of cameras that may share a view: all of a few cameras, else those with most coarse matches.

    `features` has for each camera one entry per moment.
    """
    every = list(combinations(range(len(features)), 2))
    if len(features) <= _ALL_PAIRS:
        return every
    coarse = [  # sorted last
        [Features(one.xy[-_COARSE:], one.descriptors[-_COARSE:]) for one in moments] for moments in features
    ]
    alike = np.zeros((len(features), len(features)), int)
    for a, b in every:
        found = sum(len(mutual_matches(*both)) for both in zip(coarse[a], coarse[b], strict=True))
        alike[a, b] = alike[b, a] = found
    partners = np.argsort(-alike, axis=1, kind="stable")[:, :_PARTNERS]
    wanted = {(min(a, b), max(a, b)) for a, row in enumerate(partners) for b in row.tolist() if a != b}
    return sorted(pair for pair in wanted if alike[pair] >= _FEWEST_COARSE)


def match_moments(first: Sequence[Features], second: Sequence[Features]) -> PairMatches | None:
    """Return the matches of two cameras, each within its moment, that agree with one epipolar geometry; None if few do.

    Both sequences have one entry per moment, in the same order. Equal input gives equal matches.
    """
    from hgs_core.points.colmap_points import pycolmap

    rows, moments, start = [], [], np.zeros(2, np.uint32)
    for moment, (one, other) in enumerate(zip(first, second, strict=True)):
        found = mutual_matches(one, other)
        rows.append(found + start)
        moments.append(np.full(len(found), moment))
        start = start + np.array([len(one.xy), len(other.xy)], np.uint32)
    matched, moment_of = np.concatenate(rows), np.concatenate(moments)
    if len(matched) < _FEWEST:
        return None
    x1 = np.concatenate([one.xy for one in first])[matched[:, 0]]
    x2 = np.concatenate([one.xy for one in second])[matched[:, 1]]
    options = pycolmap.RANSACOptions(
        max_error=_MAX_ERROR, min_inlier_ratio=_LEAST_SHARE, max_num_trials=_TRIALS, random_seed=0
    )
    estimate = pycolmap.estimate_fundamental_matrix(x1, x2, options)
    if estimate is None:
        return None
    agree = np.asarray(estimate["inlier_mask"], bool)
    if agree.sum() < _FEWEST or agree.mean() < _LEAST_SHARE:
        return None
    return PairMatches(matched[agree], x1[agree], x2[agree], moment_of[agree])
