"""Rigs with poses that are all reflections, as tools with a left-handed world write them: their meaning is tried."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hgs_core.capture.cameras.rigid_poses import MIRROR
from hgs_core.capture.capture import Capture
from hgs_core.check.causes import cause_of_rig
from hgs_core.check.epipolar import ComparedPairs, Pairs, Rig
from hgs_core.check.findings import Finding
from hgs_core.check.poses_by_motion import SilhouettesOfRig
from hgs_core.scene.camera import Camera

__all__ = ["as_stored", "judge_left_handed"]

_TOLD = "the poses of all cameras are reflections"


def as_stored(rig: Rig) -> Rig:
    """Return the rig of a mirrored capture with the reflections that its file has."""
    return Rig(rig.intrinsics, rig.poses @ MIRROR)


def judge_left_handed(capture: Capture, sizes: Sequence[Camera], pairs: Pairs) -> list[Finding]:
    """Return the findings on a mirrored capture: the first stops, and names the meaning of its poses, if there is one.

    By features where they connect all cameras, else by the silhouettes of what moves.

    Args:
        capture: with poses that are all reflections, the world's x turned.
        sizes: its cameras at the sizes that distances are measured in.
        pairs: matches of features.

    Raises:
        InputError: a picture or a mask is unreadable or of a wrong size.
    """
    rig, names = as_stored(Rig.of(sizes)), [camera.name for camera in sizes]
    cause = cause_of_rig(rig, pairs, names) if _connected(len(sizes), pairs) else None
    if cause is not None:
        return [cause.finding(True, (), _TOLD, names, digits=2)]
    found: list[Finding] = []
    if len(sizes) > 1 and len(capture.times) > 1:
        shapes = SilhouettesOfRig.of(capture, sizes, range(len(sizes)))
        if _connected(len(sizes), shapes.pairs):
            found = shapes.whole_rig(rig, _TOLD, np.inf)
    if found:
        return found
    cure = "export with right-handed axes: neither features nor what moves tell which way they are meant"
    return [Finding(True, (), f"{_TOLD}, which mirrors the scene", cure)]


def _connected(count: int, pairs: ComparedPairs) -> bool:
    """Whether pairs lead from each camera to every other."""
    reached, seen = {0}, 0
    while len(reached) > seen:
        seen = len(reached)
        reached |= {camera for pair in pairs if reached & set(pair) for camera in pair}
    return len(reached) == count
