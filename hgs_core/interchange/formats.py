"""Which file is read and written by which module: by its suffix, and a .ply by its properties."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.interchange.cubic import as_cubics
from hgs_core.interchange.gaussian_ply import gaussian_ply, gaussian_splats
from hgs_core.interchange.moment import scene_at
from hgs_core.interchange.ply_table import read_ply
from hgs_core.interchange.spacetime_ply import is_spacetime, spacetime_ply, spacetime_splats
from hgs_core.interchange.splat_file import read_splat, splat_file
from hgs_core.interchange.splatv_file import splatv_file
from hgs_core.interchange.spz_file import read_spz, spz_file
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats

__all__ = ["EXPORTED", "IMPORTED", "Imported", "export_scene", "import_scene"]

IMPORTED = (".ply", ".splat", ".spz")
EXPORTED = (".ply", ".splat", ".splatv", ".spz")
_NOT_STORED = "the scene was trained antialiased, which this format cannot say: without it thin splats show too strong"

LARGEST_LOGIT = 13.8  # an opacity of 1 - 1e-6
LEAST_LOG_SCALE = -30.0

Floats = NDArray[np.float32]
S = TypeVar("S", StaticSplats[NDArray[np.float32]], DynamicSplats[NDArray[np.float32]])


@dataclass(frozen=True)
class Imported:
    """What a file holds."""

    scene: HybridScene[Floats]
    antialiased: bool
    notes: tuple[str, ...]  # what was left out, for people


def import_scene(path: Path, duration: float) -> Imported:
    """Read a file of splats; a 4D one lasts `duration` seconds, a still one no time. Splats that are no numbers go.

    Raises:
        InputError: an unknown suffix, or the file is missing, damaged or holds no splats.
    """
    if path.suffix not in IMPORTED:
        raise InputError(path, f"has the suffix {path.suffix or 'none'!r}", f"give one of {', '.join(IMPORTED)}")
    static, dynamic = StaticSplats.empty(), DynamicSplats.empty()
    antialiased, end = False, 0.0
    notes: list[str] = []
    if path.suffix == ".spz":
        static, antialiased, notes = read_spz(path)
    elif path.suffix == ".splat":
        static = read_splat(path)
    else:
        table = read_ply(path)
        if is_spacetime(table):
            static, dynamic, notes = spacetime_splats(path, table)
            end = duration
        else:
            static, notes = gaussian_splats(path, table)
    counts = len(static) + len(dynamic)
    static, dynamic = _drawable(static.take(_numbers(static))), _drawable(dynamic.take(_numbers(dynamic)))
    lost = counts - len(static) - len(dynamic)
    if lost:
        notes = [*notes, f"{lost} of {counts} splats left out: they have numbers that are not finite"]
    if counts == lost:
        raise InputError(path, "holds no splats", "give a file with at least one")
    return Imported(HybridScene(static, (Segment(0.0, end, dynamic),)), antialiased, tuple(notes))


def export_scene(
    scene: HybridScene[Floats],
    path: Path,
    *,
    cameras: Sequence[Camera],
    antialiased: bool,
    time: float | None = None,
    segment: int | None = None,
) -> list[str]:
    """Write a scene to `path`, in the format of its suffix, atomically; returns notes on what the format lacks.

    With `time` (seconds) the scene as it stands then. Without it, .ply is 3DGS's if nothing moves and else, like
    .splatv, the whole of a segment: `segment` names which, and is needed where there are several.

    Raises:
        InputError: an unknown suffix, a time or segment that is missing, needless or not the scene's, or coordinates
            that the format cannot hold.
    """
    if path.suffix not in EXPORTED:
        raise InputError(path, f"has the suffix {path.suffix or 'none'!r}", f"give one of {', '.join(EXPORTED)}")
    moving = any(len(part.dynamic) for part in scene.segments)
    notes = [_NOT_STORED] if antialiased and path.suffix != ".spz" else []
    if path.suffix == ".splatv" and time is not None:
        raise InputError("--time", "is not for .splatv, which holds all times", "leave it out, or export .splat")
    if time is not None and not scene.start <= time <= scene.end:
        raise InputError("--time", f"{time} s is outside the scene", f"give {scene.start:g} to {scene.end:g}")
    if path.suffix == ".splatv" or (path.suffix == ".ply" and time is None and moving):
        part = _segment(scene, segment)
        dynamic, fifth, error = as_cubics(part.dynamic)
        if fifth:
            notes.append(f"{fifth} motions of the fifth order became cubics, off by at most {error:.3g} world units")
        if path.suffix == ".ply":
            write_bytes(path, spacetime_ply(scene.static, dynamic))
        else:
            write_bytes(path, splatv_file(scene.static, dynamic, cameras))
        return [*notes, f"its times 0 to 1 are {part.start:g} to {part.end:g} s"]
    if moving and time is None:
        raise InputError(path, "holds one moment, and this scene moves", f"add --time {scene.start:g} to {scene.end:g}")
    splats = scene.static if time is None else scene_at(scene, time)
    write = {".ply": gaussian_ply, ".splat": splat_file}.get(path.suffix)
    write_bytes(path, spz_file(splats, antialiased=antialiased) if write is None else write(splats))
    return notes


def _segment(scene: HybridScene[Floats], number: int | None) -> Segment[Floats]:
    count = len(scene.segments)
    if number is None and count > 1:
        raise InputError("--segment", f"is missing: the scene has {count} segments", f"give one of 0 to {count - 1}")
    if not 0 <= (number or 0) < count:
        raise InputError("--segment", f"{number} is not one of the scene's", f"give one of 0 to {count - 1}")
    return scene.segments[number or 0]


def _drawable(splats: S) -> S:
    """Give opacities of 0 and 1 a logit, and flat axes a logarithm: renderers take finite numbers alone."""
    return dataclasses.replace(
        splats,
        opacity_logits=np.clip(splats.opacity_logits, -LARGEST_LOGIT, LARGEST_LOGIT),
        log_scales=np.maximum(splats.log_scales, LEAST_LOG_SCALE),
    )


def _numbers(splats: StaticSplats[Floats] | DynamicSplats[Floats]) -> NDArray[np.bool_]:
    """Tell which splats are finite; no thickness, and opacities of 0 and 1, are."""
    good = np.ones(len(splats), np.bool_)
    for name, array in splats.items():
        valid = np.isfinite(array)
        if name == "log_scales":
            valid |= np.isneginf(array)
        if name == "opacity_logits":
            valid |= np.isinf(array)
        good &= valid.reshape(len(splats), -1).all(axis=1) if len(splats) else good
    return good
