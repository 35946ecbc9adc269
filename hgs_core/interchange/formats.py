"""Which file is read and written by which module: by its suffix, and a .ply by its properties."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Floats
from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.interchange.changes import Action, Change, Written, nonzero
from hgs_core.interchange.cubic import as_cubics
from hgs_core.interchange.gaussian_ply import gaussian_ply, gaussian_splats
from hgs_core.interchange.moment import scene_at
from hgs_core.interchange.ply_table import read_ply
from hgs_core.interchange.spacetime_ply import is_spacetime, spacetime_ply, spacetime_splats
from hgs_core.interchange.splat_file import read_splat, splat_file
from hgs_core.interchange.splatv_file import splatv_file
from hgs_core.interchange.spz_file import read_spz, spz_file
from hgs_core.scene.camera import Camera
from hgs_core.scene.opacities import opacities_of
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats

__all__ = ["EXPORTED", "IMPORTED", "Imported", "export_scene", "import_scene"]

IMPORTED = (".ply", ".splat", ".spz")
EXPORTED = (".ply", ".splat", ".splatv", ".spz")

LARGEST_LOGIT = 13.82  # an opacity of 1 - 1e-6
LARGEST_LOG_SCALE = 30.0
LARGEST_RGB = 8.0
LEAST_OPACITY = 1 / 255  # below it no pixel is touched
BLACK = (0.0, 0.0, 0.0)
_WORDS = {
    "means": "position", "motion": "position or motion", "log_scales": "scale", "quats": "rotation",
    "rotation": "rotation or turning", "opacity_logits": "opacity", "rgb": "colour", "time_centers": "middle of life",
    "time_log_precisions": "life",
}  # fmt: skip

S = TypeVar("S", StaticSplats[NDArray[np.float32]], DynamicSplats[NDArray[np.float32]])


@dataclass(frozen=True)
class Imported:
    """What a file holds."""

    scene: HybridScene[Floats]
    splats: int  # in the file
    changes: tuple[Change, ...]  # what was left out or changed of them


def import_scene(path: Path, duration: float) -> Imported:
    """Read a file of splats; a 4D one lasts `duration` seconds, a still one no time. Splats that are no numbers go.

    Raises:
        InputError: an unknown suffix, or the file is missing, damaged, or holds no splat that can be seen.
    """
    if path.suffix not in IMPORTED:
        raise InputError(path, f"has the suffix {path.suffix or 'none'!r}", f"give one of {', '.join(IMPORTED)}")
    static, dynamic = StaticSplats.empty(), DynamicSplats.empty()
    antialiased, end = False, 0.0
    changes: list[Change] = []
    if path.suffix == ".spz":
        static, antialiased, changes = read_spz(path)
    elif path.suffix == ".splat":
        static = read_splat(path)
    else:
        table, changes = read_ply(path)
        if is_spacetime(table):
            static, dynamic, more = spacetime_splats(path, table)
            end = duration
        else:
            static, more = gaussian_splats(path, table)
        changes += more
    total = len(static) + len(dynamic)
    if total == 0:
        raise InputError(path, "holds no splats", "give a file with at least one")
    static, lost = _finite(static)
    dynamic, lost_moving = _finite(dynamic)
    for words in dict.fromkeys((*lost, *lost_moving)):
        count = lost.get(words, 0) + lost_moving.get(words, 0)
        changes.append(Change(Action.LEFT_OUT, "splats", count, total, f"{words} is no finite number"))
    changes += _limits(static, dynamic)
    static, dynamic = _drawable(static), _drawable(dynamic)
    if not any((opacities_of(splats.opacity_logits) >= LEAST_OPACITY).any() for splats in (static, dynamic)):
        told = "; ".join(map(str, nonzero(changes)))
        raise InputError(path, "holds no splat that can be seen" + (f": {told}" if told else ""), "export it again")
    scene = HybridScene(static, (Segment(0.0, end, dynamic),), antialiased=antialiased)
    return Imported(scene, total, nonzero(changes))


def export_scene(
    scene: HybridScene[Floats],
    path: Path,
    *,
    cameras: Sequence[Camera],
    time: float | None = None,
    segment: int | None = None,
) -> tuple[Change, ...]:
    """Write a scene to `path`, in the format of its suffix, atomically; returns what the file lacks of it.

    With `time` (seconds) the scene as it stands then. Without it, .ply is 3DGS's if nothing moves and else, like
    .splatv, the whole of a segment: `segment` names which, and is needed where there are several.

    Raises:
        InputError: an unknown suffix, a time or segment that is missing, needless or not the scene's, or coordinates
            that the format cannot hold.
    """
    if path.suffix not in EXPORTED:
        raise InputError(path, f"has the suffix {path.suffix or 'none'!r}", f"give one of {', '.join(EXPORTED)}")
    moving = any(len(part.dynamic) for part in scene.segments)
    changes: list[Change] = []
    if scene.antialiased and path.suffix != ".spz":
        reason = "the format cannot say that the scene was trained so, and without it thin splats show too strong"
        changes.append(Change.whole(Action.LEFT_OUT, "antialiasing", reason))
    if scene.background != BLACK:
        changes.append(Change.whole(Action.LEFT_OUT, "background", "the format has none"))
    if path.suffix == ".splatv" and time is not None:
        raise InputError("--time", "is not for .splatv, which holds all times", "leave it out, or export .splat")
    if time is not None and not scene.start <= time <= scene.end:
        raise InputError("--time", f"{time} s is outside the scene", f"give {scene.start:g} to {scene.end:g}")
    if path.suffix == ".splatv" or (path.suffix == ".ply" and time is None and moving):
        written, more = _moving_file(scene, _segment(scene, segment), path.suffix, cameras)
    elif moving and time is None:
        raise InputError(path, "holds one moment, and this scene moves", f"add --time {scene.start:g} to {scene.end:g}")
    else:
        splats = scene.static if time is None else scene_at(scene, time)
        write = {".ply": gaussian_ply, ".splat": splat_file}.get(path.suffix)
        written = spz_file(splats, antialiased=scene.antialiased) if write is None else write(splats)
        more = [] if time is None else _lost_in_a_moment(scene, splats, time)
    write_bytes(path, written.data)
    return nonzero((*changes, *more, *written.changes))


def _moving_file(
    scene: HybridScene[Floats], part: Segment[Floats], suffix: str, cameras: Sequence[Camera]
) -> tuple[Written, list[Change]]:
    """Write a segment in a format of moving splats, .ply or .splatv."""
    total = _splats(scene)
    others = total - len(scene.static) - len(part.dynamic)
    dynamic, fifth, error = as_cubics(part.dynamic)
    nearest = f"a motion of the fifth order, by the nearest cubic, off by at most {error:.3g} world units"
    changes = [
        Change(Action.LEFT_OUT, "splats", others, total, "they are of other segments"),
        Change(Action.REPLACED, "motion", fifth, total, nearest),
        Change.whole(Action.REPLACED, "time", f"0 to 1 stands for {part.start:g} to {part.end:g} s"),
    ]
    if suffix == ".ply":
        return spacetime_ply(scene.static, dynamic), changes
    return splatv_file(scene.static, dynamic, cameras), changes


def _lost_in_a_moment(scene: HybridScene[Floats], kept: StaticSplats[Floats], time: float) -> list[Change]:
    total, moment = _splats(scene), f"the file holds {time:g} s alone"
    return [
        Change(Action.LEFT_OUT, "splats", total - len(kept), total, f"they are not seen then, and {moment}"),
        Change(Action.LEFT_OUT, "motion and life", len(kept) - len(scene.static), total, moment),
    ]


def _splats(scene: HybridScene[Floats]) -> int:
    return len(scene.static) + sum(len(segment.dynamic) for segment in scene.segments)


def _segment(scene: HybridScene[Floats], number: int | None) -> Segment[Floats]:
    count = len(scene.segments)
    if number is None and count > 1:
        raise InputError("--segment", f"is missing: the scene has {count} segments", f"give one of 0 to {count - 1}")
    if not 0 <= (number or 0) < count:
        raise InputError("--segment", f"{number} is not one of the scene's", f"give one of 0 to {count - 1}")
    return scene.segments[number or 0]


def _limits(static: StaticSplats[Floats], dynamic: DynamicSplats[Floats]) -> list[Change]:
    """Return what `_drawable` changes."""
    logits, scales, rgb = (
        np.concatenate([getattr(static, name), getattr(dynamic, name)])
        for name in ("opacity_logits", "log_scales", "rgb")
    )
    return [
        Change.where(Action.LIMITED, "opacity", np.abs(logits) > LARGEST_LOGIT, "to 0.000001 to 0.999999"),
        Change.where(
            Action.LIMITED, "scale", np.abs(scales) > LARGEST_LOG_SCALE,
            f"to e^{-LARGEST_LOG_SCALE:g} to e^{LARGEST_LOG_SCALE:g}",
        ),
        Change.where(Action.LIMITED, "colour", (rgb < 0) | (rgb > LARGEST_RGB), f"to 0 to {LARGEST_RGB:g}"),
    ]  # fmt: skip


def _drawable(splats: S) -> S:
    """Give opacities of 0 and 1 a logit, and flat axes a logarithm: renderers take finite numbers alone."""
    return dataclasses.replace(
        splats,
        opacity_logits=np.clip(splats.opacity_logits, -LARGEST_LOGIT, LARGEST_LOGIT),
        log_scales=np.clip(splats.log_scales, -LARGEST_LOG_SCALE, LARGEST_LOG_SCALE),
        rgb=np.clip(splats.rgb, 0, LARGEST_RGB),
    )


def _finite(splats: S) -> tuple[S, dict[str, int]]:
    """Return the splats that are finite, and how many of the others each attribute was the first to fail.

    No thickness, and opacities of 0 and 1, count as finite.
    """
    good = np.ones(len(splats), np.bool_)
    lost: dict[str, int] = {}
    for name, array in splats.items():
        valid = np.isfinite(array)
        if name == "log_scales":
            valid |= np.isneginf(array)
        if name == "opacity_logits":
            valid |= np.isinf(array)
        failed = good & ~valid.reshape(len(splats), -1).all(axis=1) if len(splats) else good
        if failed.any():
            lost[_WORDS[name]] = int(failed.sum())
        good &= ~failed
    return splats.take(good), lost
