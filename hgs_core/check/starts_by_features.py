"""By how many frames cameras are ahead of others, by features that move and must lie on each other's epipolar lines.

A point that moves lies on its epipolar line at its own moment only. Seen late it lies beside the line, by its velocity
across the line times the lead: each match of two cameras gives an estimate of the lead between them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hgs_core.check.epipolar import Rig, signed_distances
from hgs_core.check.evidence import CameraEvidence
from hgs_core.points.features import Features, mutual_matches

__all__ = ["Leads", "feature_offsets", "match_leads"]

_FARTHEST = 40.0  # pixels from the line that a match may lie
_REACH = 40.0  # pixels that a feature may move by in a frame
_SLOWEST = 0.4  # pixels per frame across the line; slower matches tell little
_FEWEST = 20  # matches of a camera
_LONGEST = 15.0  # frames; estimates beyond are chance
_FIRST_WIDTH = 3.0  # frames: before cameras agree their offsets are not near to those of their partners
_WIDTH = 0.35  # frames: how near true estimates come
_ROUNDS = 30

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Leads:
    """N estimates of by how many frames camera `second` is ahead of camera `first`, from one match each."""

    first: npt.NDArray[np.int64]  # [N] camera
    second: npt.NDArray[np.int64]  # [N] camera
    frames: Floats  # [N]
    weights: Floats  # [N] pixels per frame across the line


def match_leads(rig: Rig, pairs: Iterable[tuple[int, int]], views: Sequence[CameraEvidence]) -> Leads:
    """Return the votes of all pairs' matches, in both directions."""
    frames, weights, cameras = [np.zeros(0)], [np.zeros(0)], [np.zeros((0, 2), np.int64)]
    for a, b in (way for pair in pairs for way in (pair, pair[::-1])):
        fundamental = rig.fundamental(a, b)
        for moment, soon in views[b].soon.items():
            lead, weight = _leads(fundamental, views[a].moving[moment], views[b].moving[moment], soon)
            frames.append(lead)
            weights.append(weight)
            cameras.append(np.tile(np.array([[a, b]]), (len(lead), 1)))
    first, second = np.concatenate(cameras).T
    return Leads(first, second, np.concatenate(frames), np.concatenate(weights))


def _leads(fundamental: Floats, first: Features, second: Features, soon: Features) -> tuple[Floats, Floats]:
    """Return an estimate of the lead from each match, frames, and how much it counts."""
    steps = mutual_matches(second, soon)
    next_place = {int(one): soon.xy[two] for one, two in steps if np.hypot(*(soon.xy[two] - second.xy[one])) < _REACH}
    rows = np.array([row for row in mutual_matches(first, second) if int(row[1]) in next_place], np.int64)
    if len(rows) == 0:
        return np.zeros(0), np.zeros(0)
    x1, x2 = first.xy[rows[:, 0]], second.xy[rows[:, 1]]
    later = np.array([next_place[int(row)] for row in rows[:, 1]])
    distance = signed_distances(fundamental, x1, x2)
    speed = signed_distances(fundamental, x1, later) - distance
    kept = (np.abs(distance) < _FARTHEST) & (np.abs(speed) > _SLOWEST) & (np.abs(distance) < _LONGEST * np.abs(speed))
    # The second camera shows the point `speed` farther after each frame.
    return distance[kept] / speed[kept], np.abs(speed[kept])


def feature_offsets(count: int, leads: Leads, least_share: float = 0.4) -> list[float | None]:
    """Return by how many frames each camera is ahead of most of them; None for one of which too little tells.

    `least_share` of what a camera's matches tell, by weight, must agree.

    Robust: each camera's offset is where most of what its matches tell lies, again and again until they agree.
    """
    offsets, shares = np.zeros(count), np.zeros(count)
    for width in np.geomspace(_FIRST_WIDTH, _WIDTH, _ROUNDS):
        for camera in range(count):
            second, first = leads.second == camera, leads.first == camera
            told = np.concatenate(
                (
                    offsets[leads.first[second]] + leads.frames[second],
                    offsets[leads.second[first]] - leads.frames[first],
                )
            )
            if len(told) >= _FEWEST:
                weights = np.concatenate((leads.weights[second], leads.weights[first]))
                offsets[camera], shares[camera] = _densest(told, weights, width)
    known = [camera for camera in range(count) if shares[camera] >= least_share]
    middle = float(np.median(offsets[known])) if known else 0.0
    return [float(offsets[camera]) - middle if camera in known else None for camera in range(count)]


def _densest(values: Floats, weights: Floats, width: float) -> tuple[float, float]:
    """Return around which value most of the weight lies, and the share of it that does; the rest is chance."""
    near = np.exp(-0.5 * ((values[:, None] - values) / width) ** 2) * weights
    best = int(near.sum(axis=1).argmax())
    around = np.abs(values - values[best]) < 2 * width
    place = float(np.average(values[around], weights=weights[around]))
    return place, float(weights[around].sum() / weights.sum())
