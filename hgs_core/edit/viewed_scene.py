"""A scene with its cameras and clock, which edits change together."""

from __future__ import annotations

from dataclasses import dataclass

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.interchange.changes import Change
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import HybridScene

__all__ = ["Edit", "ViewedScene", "shown_until"]


@dataclass(frozen=True)
class ViewedScene:
    """Splats with the manifest's other fields."""

    scene: HybridScene[Floats]
    cameras: tuple[Camera, ...]  # none: they were made up, and will be again
    times: Doubles  # [F] seconds of the frames, increasing
    up: tuple[float, float, float] | None = None  # unit vector that somebody chose; None: what the cameras tell
    begins: float = 0.0  # seconds, on the clock before trimming


@dataclass(frozen=True)
class Edit:
    """An edited scene and its losses from the one before."""

    viewed: ViewedScene
    changes: tuple[Change, ...] = ()


def shown_until(scene: HybridScene[Floats], number: int) -> float:
    """Return the second until which a segment is shown: the next one's start, or its own end if it is the last."""
    later = scene.segments[number + 1 :]
    return later[0].start if later else scene.segments[number].end
