"""A scene with the cameras and the clock it is looked at with: what edits change together."""

from __future__ import annotations

from dataclasses import dataclass

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.interchange.changes import Change
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import HybridScene

__all__ = ["Edit", "ViewedScene", "shown_until"]


@dataclass(frozen=True)
class ViewedScene:
    """Splats, and what a manifest says beside them."""

    scene: HybridScene[Floats]
    cameras: tuple[Camera, ...]  # none: they were made up, and will be again
    times: Doubles  # [F] seconds of the frames, increasing
    up: tuple[float, float, float] | None = None  # unit vector that somebody chose; None: what the cameras tell
    begins: float = 0.0  # when, on the clock that it had before it was trimmed, seconds


@dataclass(frozen=True)
class Edit:
    """An edited scene and what it lacks of the one before."""

    viewed: ViewedScene
    changes: tuple[Change, ...] = ()


def shown_until(scene: HybridScene[Floats], number: int) -> float:
    """Return the second until which a segment is shown: the next one's start, or its own end if it is the last."""
    later = scene.segments[number + 1 :]
    return later[0].start if later else scene.segments[number].end
