"""Export of a scene to a file of another format, with the losses."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hgs_core.base.arrays import Floats
from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.base.progress import ProgressCallback
from hgs_core.interchange.changes import Action, Change, nonzero
from hgs_core.interchange.cubic import as_cubics
from hgs_core.interchange.formats import format_of, frame_format
from hgs_core.interchange.frame_sequence import write_sequence
from hgs_core.interchange.still_moment import scene_at
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats

__all__ = ["export_scene", "export_sequence"]

BLACK = (0.0, 0.0, 0.0)


def export_scene(
    scene: HybridScene[Floats],
    path: Path,
    *,
    cameras: Sequence[Camera],
    time: float | None = None,
    segment: int | None = None,
    version: int | None = None,
    frame_rate: float = 30.0,
) -> tuple[Change, ...]:
    """Write a scene to `path`, in the format of its suffix, atomically; return the losses.

    With `time` (seconds) the scene as it stands then. Without it, .ply is 3DGS's if nothing moves and else, like
    .splatv, the whole of a segment: `segment` names which, and is needed where there are several.
    `version` is that of .spz, `frame_rate` that of the samples of .usd.

    Raises:
        InputError: an unknown suffix, a time or segment that is missing, needless or not the scene's, or coordinates
            that the format cannot hold.
    """
    target = format_of(path, lambda one: any((one.write_still, one.write_moving, one.write_whole)))
    if version is not None and version not in target.versions:
        raise InputError(
            "--spz-version", f"{version} is none of {path.suffix}", "leave it out, or give 2 to 4 for .spz"
        )
    moving = scene.dynamic_splats > 0
    changes = _unsaid(scene)
    more: list[Change] = []
    if target.write_whole is not None and segment is not None:
        raise InputError("--segment", f"is not for {path.suffix}, which holds all of them", "leave it out")
    if target.write_still is None and time is not None:
        raise InputError("--time", f"is not for {path.suffix}, which holds all times", "leave it out, or export .splat")
    if time is not None and not scene.start <= time <= scene.end:
        raise InputError("--time", f"{time} s is outside the scene", f"give {scene.start:g} to {scene.end:g}")
    if target.write_whole is not None and (target.write_still is None or time is None):
        written = target.write_whole(scene, frame_rate)
    elif target.write_moving is not None and (target.write_still is None or (time is None and moving)):
        dynamic, more = _as_cubics(scene, segment)
        written = target.write_moving(scene.static, dynamic, cameras, scene.antialiased)
    elif moving and time is None:
        raise InputError(path, "holds one moment, and this scene moves", f"add --time {scene.start:g} to {scene.end:g}")
    else:
        write = target.write_still if version is None else target.versions[version]
        assert write is not None
        splats = scene.static if time is None else scene_at(scene, time)
        written = write(splats, scene.antialiased)
        more = [] if time is None else _lost_in_a_moment(scene, splats, time)
    write_bytes(path, written.data)
    return nonzero((*changes, *more, *written.changes))


def export_sequence(
    scene: HybridScene[Floats], folder: Path, frame_rate: float, progress: ProgressCallback, frames: str = "ply"
) -> tuple[Change, ...]:
    """Write a scene that moves as a folder of files, one for each frame, of the format `frames`; return the losses.

    Raises:
        InputError: see `frame_format` and `write_sequence`.
    """
    changes = write_sequence(scene, folder, frame_format(frames), frame_rate, progress)
    return nonzero((*_unsaid(scene), *changes))


def _unsaid(scene: HybridScene[Floats]) -> list[Change]:
    """Return the settings of drawing that no format can hold."""
    if scene.background == BLACK:
        return []
    return [Change.whole(Action.LEFT_OUT, "background", "the format has none")]


def _as_cubics(scene: HybridScene[Floats], number: int | None) -> tuple[DynamicSplats[Floats], list[Change]]:
    """Return a segment's dynamic set in the form of moving splats' formats, and the losses."""
    part, total = _segment(scene, number), _splats(scene)
    others = total - len(scene.static) - len(part.dynamic)
    dynamic, fifth, error = as_cubics(part.dynamic)
    nearest = f"a motion of the fifth order, by the nearest cubic, off by at most {error:.3g} world units"
    return dynamic, [
        Change(Action.LEFT_OUT, "splats", others, total, "they are of other segments"),
        Change(Action.REPLACED, "motion", fifth, total, nearest),
        Change.whole(Action.REPLACED, "time", f"0 to 1 stands for {part.start:g} to {part.end:g} s"),
    ]


def _lost_in_a_moment(scene: HybridScene[Floats], kept: StaticSplats[Floats], time: float) -> list[Change]:
    total, moment = _splats(scene), f"the file holds {time:g} s alone"
    return [
        Change(Action.LEFT_OUT, "splats", total - len(kept), total, f"they are not seen then, and {moment}"),
        Change(Action.LEFT_OUT, "motion and life", len(kept) - len(scene.static), total, moment),
    ]


def _splats(scene: HybridScene[Floats]) -> int:
    return len(scene.static) + scene.dynamic_splats


def _segment(scene: HybridScene[Floats], number: int | None) -> Segment[Floats]:
    count = len(scene.segments)
    if number is None and count > 1:
        raise InputError("--segment", f"is missing: the scene has {count} segments", f"give one of 0 to {count - 1}")
    if not 0 <= (number or 0) < count:
        raise InputError("--segment", f"{number} is not one of the scene's", f"give one of 0 to {count - 1}")
    return scene.segments[number or 0]
