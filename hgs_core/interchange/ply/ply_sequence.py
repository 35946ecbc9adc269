"""PLY sequences: a folder of numbered 3DGS .ply files, one for each frame, as SuperSplat plays them."""

from __future__ import annotations

import dataclasses
import itertools
import re
import secrets
import shutil
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.interchange.changes import Action, Change, most_of_any
from hgs_core.interchange.file_format import NOTHING_KNOWN, Reading, ReadSplats
from hgs_core.interchange.ply.gaussian_ply import gaussian_ply
from hgs_core.interchange.ply.ply_file import PLY
from hgs_core.interchange.still_moment import scene_at
from hgs_core.scene.at_rest import at_rest
from hgs_core.scene.rows import rows_of
from hgs_core.scene.splats import HybridScene
from hgs_core.scene.temporal import lifetime

__all__ = ["frame_files", "is_sequence", "read_sequence", "write_sequence"]

SPLAT_BYTES = 68  # bytes of a splat in a 3DGS file of degree 0
_NUMBERED = re.compile(r"(.*?)(\d+)\.ply", re.IGNORECASE)


def is_sequence(path: Path) -> bool:
    """Return whether a path stands for a folder of frames: it is one, or has no suffix."""
    return path.is_dir() or not path.suffix


def write_sequence(
    scene: HybridScene[Floats], folder: Path, frame_rate: float, progress: ProgressCallback
) -> tuple[Change, ...]:
    """Write a scene that moves as `folder`/frame_0000.ply and so on; return the losses.

    One frame is in memory at a time; the folder appears when all are written.

    Raises:
        InputError: nothing moves, the rate is not positive, the folder holds something, or the disk is too full.
    """
    if not scene.dynamic_splats:
        raise InputError("scene", "does not move, and a folder is for frames", f"export {folder.name}.ply")
    if not frame_rate > 0:
        raise InputError("--fps", f"{frame_rate:g} is not positive", "give frames for each second, like 30")
    if folder.exists() and not (folder.is_dir() and not any(folder.iterdir())):
        raise InputError(folder, "holds something", "name a new folder")
    count = int((scene.end - scene.start) * frame_rate + 1e-6) + 1
    times = np.minimum(scene.start + np.arange(count) / frame_rate, scene.end)
    shown, unseen = _seen(scene, times)
    needed = SPLAT_BYTES * (count * len(scene.static) + shown)
    folder.parent.mkdir(parents=True, exist_ok=True)
    free = shutil.disk_usage(folder.parent).free
    if needed > free:
        problem = f"needs {needed:,} bytes for {count:,} frames, and {free:,} are free"
        raise InputError(folder, problem, "give a lower --fps, or name another disk")
    temporary = folder.with_name(f".{folder.name}.{secrets.token_hex(6)}.tmp")
    temporary.mkdir()
    changes: list[Change] = []
    try:
        for number, seconds in enumerate(times):
            written = gaussian_ply(scene_at(scene, float(seconds)), scene.antialiased)
            (temporary / f"frame_{number:0{max(4, len(str(count - 1)))}}.ply").write_bytes(written.data)
            changes += written.changes
            progress(Progress("export", number + 1, count))
        temporary.replace(folder)
    except BaseException:
        shutil.rmtree(temporary, ignore_errors=True)
        raise
    total = len(scene.static) + scene.dynamic_splats
    clock = (
        f"{count} files show {scene.start:g} to {times[-1]:g} s, and do not tell that they are {frame_rate:g} a second"
    )
    return (
        Change(Action.LEFT_OUT, "splats", unseen, total, "no frame shows them"),
        Change(Action.REPLACED, "motion and life", scene.dynamic_splats, total, "by copies that stand still"),
        Change.whole(Action.REPLACED, "time", clock),
        *most_of_any(changes),
    )


def _seen(scene: HybridScene[Floats], times: Doubles) -> tuple[int, int]:
    """Return how many splats that move all frames have together, and how many are in none."""
    shown, unseen = 0, 0
    which = np.array([next(i for i, s in enumerate(scene.segments) if s is scene.segment_at(t)) for t in times])
    for number, segment in enumerate(scene.segments):
        moments = np.array([segment.normalised(t) for t in times[which == number]])
        start, end = lifetime(segment.dynamic)
        frames = np.searchsorted(moments, end, "right") - np.searchsorted(moments, start, "left")
        shown += int(np.maximum(frames, 0).sum())
        unseen += int((frames <= 0).sum())
    return shown, unseen


def frame_files(folder: Path) -> list[Path]:
    """Return the frames of a folder, in order of their numbers.

    Raises:
        InputError: there are fewer than two, their names differ in more than the number, or one is missing.
    """
    found = {path: match for path in folder.iterdir() if (match := _NUMBERED.fullmatch(path.name))}
    names = sorted({match[1] for match in found.values()})
    if len(found) < 2 or len(names) > 1:
        has = f"has numbered .ply files that begin with {' and '.join(names)}" if names[1:] else "holds no frames"
        raise InputError(folder, has, "give a folder with one set of files like frame_0000.ply, frame_0001.ply")
    numbers = {int(match[2]): path for path, match in found.items()}
    order = sorted(numbers)
    step = order[1] - order[0]
    for number, following in itertools.pairwise(order):
        if following - number != step:
            problem = f"has frames {number} and {following}, and others {step} apart"
            raise InputError(folder, problem, "export the missing ones, or renumber them")
    return [numbers[number] for number in order]


def read_sequence(folder: Path, reading: Reading = NOTHING_KNOWN) -> ReadSplats:
    """Read the frames of a folder: splats that are in all of them are static, the others stand still for one frame.

    All frames are moved as the first one is, if its places are far from the origin.

    Raises:
        InputError: see `frame_files`; or a file is damaged or no still 3DGS .ply, or frames are drawn differently.
    """
    files = frame_files(folder)
    start = _still(files[0], reading)
    reading = dataclasses.replace(reading, middle=start.middle, centred=False)
    common: NDArray[np.void] | None = None
    changes: list[Change] = [change for change in start.changes if start.middle is not None and change.count is None]
    for file in files:
        found = _still(file, reading)
        if found.antialiased != start.antialiased:
            said = ["antialiased" if one.antialiased else "not antialiased" for one in (found, start)]
            raise InputError(file, f"is drawn {said[0]}, and {files[0].name} {said[1]}", "export the frames again")
        changes += found.changes
        rows, counts = np.unique(rows_of(found.static), return_counts=True)
        once = rows[counts == 1]
        common = once if common is None else np.intersect1d(common, once, assume_unique=True)
    assert common is not None
    first = _still(files[0], reading).static
    static = first.take(np.isin(rows_of(first), common))
    frames = []
    for file in files:
        splats = _still(file, reading).static
        frames.append(at_rest(splats.take(~np.isin(rows_of(splats), common))))
    return ReadSplats(
        static,
        tuple(frames),
        lasts=True,
        antialiased=start.antialiased,
        middle=start.middle,
        changes=most_of_any(changes),
    )


def _still(file: Path, reading: Reading) -> ReadSplats:
    assert PLY.read is not None
    found = PLY.read(file, reading)
    if found.lasts:
        raise InputError(file, "holds all times of an STGS scene, and no frame", "import it alone")
    return found
