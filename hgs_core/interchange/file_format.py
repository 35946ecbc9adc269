"""The description of one file format of splats, by the format's own module."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.interchange.changes import Change, Written
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats, HybridScene, StaticSplats

__all__ = ["NOTHING_KNOWN", "FileFormat", "ReadSplats", "Reading", "WriteStill"]

WriteStill = Callable[[StaticSplats[Floats], bool], Written]
"""Takes the splats, and whether they are drawn antialiased."""


@dataclass(frozen=True)
class Reading:
    """The facts known about a file before reading."""

    activated: bool | None = None  # whether scales and opacities stand there as they are drawn; None: find out
    centred: bool = True  # places far from the origin may be moved there
    middle: Doubles | None = None  # offset [3] to subtract from places in any case


NOTHING_KNOWN = Reading()


@dataclass(frozen=True)
class ReadSplats:
    """The splats of a file as they stand there, maybe not finite."""

    static: StaticSplats[Floats]
    dynamic: tuple[DynamicSplats[Floats], ...] = ()  # one set for each segment
    lasts: bool = False  # whether the file holds a stretch of time
    ends: tuple[float, ...] = ()  # ends of segments, seconds, if the file has them; else equal lengths
    antialiased: bool | None = None  # whether the splats are drawn so; None: the file does not say
    middle: Doubles | None = None  # offset [3] subtracted from places far from the origin
    changes: tuple[Change, ...] = ()  # omissions and changes in reading


@dataclass(frozen=True)
class FileFormat:
    """How files of one suffix are read and written; None where they cannot be."""

    suffix: str
    read: Callable[[Path, Reading], ReadSplats] | None = None
    write_still: WriteStill | None = None
    versions: Mapping[int, WriteStill] = field(default_factory=dict)  # version -> writer, if there are several
    # Takes one segment, the scene's cameras, and whether it is drawn antialiased.
    write_moving: Callable[[StaticSplats[Floats], DynamicSplats[Floats], Sequence[Camera], bool], Written] | None = None
    # Takes all times of a scene, and the rate of samples, a second.
    write_whole: Callable[[HybridScene[Floats], float], Written] | None = None
    sampled: bool = False  # whether `write_whole` samples
    frame_bytes: int = 0  # bytes of a splat in a folder of frames, at most; 0: no such folders
