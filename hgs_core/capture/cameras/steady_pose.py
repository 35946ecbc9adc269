"""One pose of a camera that stands still, out of poses that were solved picture by picture and differ a little."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

__all__ = ["differing", "median_pose", "pose_groups", "rig_radius", "same_pose", "spread", "strays"]

_SAME_TURN = 2e-3  # radians, and
_SAME_PLACE = 2e-3  # share of the rig's radius between poses of one camera: structure from motion is not exact
_MOST_STRAYS = 0.25  # share of the poses of one camera
_EXACT = 1e-5  # rounding to six digits, not worth a note

Pose = npt.NDArray[np.float64]
"""World to camera, [4, 4]."""


def rig_radius(poses: Sequence[Pose]) -> float:
    """Return how far the farthest camera is from the middle of all."""
    places = np.array([_place(pose) for pose in poses])
    return float(np.linalg.norm(places - places.mean(axis=0), axis=1).max()) if len(places) > 1 else 0.0


def same_pose(first: Pose, second: Pose, radius: float) -> bool:
    """Return whether two poses may be one camera's, in a rig of that radius."""
    turn, moved = _apart(first, second)
    return turn <= _SAME_TURN and moved <= _SAME_PLACE * radius + 1e-9


def pose_groups(poses: Sequence[Pose], radius: float) -> list[list[int]]:
    """Return the indices of poses that may be one camera's, in the order of the first of each."""
    groups: list[list[int]] = []
    firsts = np.empty((0, 4, 4))
    for index, pose in enumerate(poses):
        turns = np.linalg.norm(firsts[:, :3, :3] - pose[:3, :3], axis=(1, 2)) / np.sqrt(2)
        places = -np.einsum("nji,nj->ni", firsts[:, :3, :3], firsts[:, :3, 3])
        moved = np.linalg.norm(places - _place(pose), axis=1)
        near = np.flatnonzero((turns <= _SAME_TURN) & (moved <= _SAME_PLACE * radius + 1e-9))
        if len(near):
            groups[int(near[0])].append(index)
        else:
            groups.append([index])
            firsts = np.concatenate((firsts, pose[None]))
    return groups


def strays(poses: Sequence[Pose], radius: float) -> list[int]:
    """Return the indices of few poses that are elsewhere than all others, of a camera that stands still; else none."""
    largest = max(pose_groups(poses, radius), key=len)
    others = sorted(set(range(len(poses))) - set(largest))
    return others if len(others) <= _MOST_STRAYS * len(poses) else []


def median_pose(poses: Sequence[Pose]) -> Pose:
    """Return the pose in the middle of some that are nearly one: medians of places and turns, number by number."""
    if all(np.array_equal(pose, poses[0]) for pose in poses[1:]):
        return poses[0]
    left, _, right = np.linalg.svd(np.median([pose[:3, :3] for pose in poses], axis=0))
    found = np.eye(4)
    found[:3, :3] = left @ right
    found[:3, 3] = -found[:3, :3] @ np.median([_place(pose) for pose in poses], axis=0)
    return found


def spread(groups: Sequence[Sequence[Pose]], radius: float) -> str:
    """Return by how much poses of one camera differ, for people; empty if by no more than their digits."""
    pairs = [_apart(group[0], pose) for group in groups for pose in group[1:]]
    turn, moved = (max((pair[i] for pair in pairs), default=0.0) for i in (0, 1))
    if turn <= _EXACT and moved <= _EXACT * radius:
        return ""
    return f"up to {np.degrees(turn):.2g} degrees and {moved:.2g} units of length"


def differing(by: str) -> str:
    """Return the note on poses that differ."""
    return f"the poses of one camera differ by {by} from picture to picture; their median is taken"


def _apart(first: Pose, second: Pose) -> tuple[float, float]:
    """Return the angle, for small ones, and the distance."""
    turn = np.linalg.norm(first[:3, :3] - second[:3, :3]) / np.sqrt(2)
    return float(turn), float(np.linalg.norm(_place(first) - _place(second)))


def _place(pose: Pose) -> npt.NDArray[np.float64]:
    place: npt.NDArray[np.float64] = -pose[:3, :3].T @ pose[:3, 3]
    return place
