"""Folders of frames: a scene that moves as numbered files of a still format, as SuperSplat plays .ply files."""

from __future__ import annotations

import secrets
import shutil
from pathlib import Path

import numpy as np

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.interchange.changes import Action, Change, most_of_any
from hgs_core.interchange.file_format import FileFormat
from hgs_core.interchange.still_moment import scene_at
from hgs_core.scene.splats import HybridScene
from hgs_core.scene.temporal import lifetime

__all__ = ["write_sequence"]


def write_sequence(
    scene: HybridScene[Floats], folder: Path, frame_format: FileFormat, frame_rate: float, progress: ProgressCallback
) -> tuple[Change, ...]:
    """Write a scene that moves as `folder`/frame_0000.ply and so on, of one format; return the losses.

    One frame is in memory at a time; the folder appears when all are written.

    Raises:
        InputError: nothing moves, the rate is not positive, the folder holds something, or the disk is too full.
    """
    write, suffix = frame_format.write_still, frame_format.suffix
    assert write is not None
    if not scene.dynamic_splats:
        raise InputError("scene", "does not move, and a folder is for frames", f"export {folder.name}{suffix}")
    if not frame_rate > 0:
        raise InputError("--fps", f"{frame_rate:g} is not positive", "give frames for each second, like 30")
    if folder.exists() and not (folder.is_dir() and not any(folder.iterdir())):
        raise InputError(folder, "holds something", "name a new folder")
    count = int((scene.end - scene.start) * frame_rate + 1e-6) + 1
    times = np.minimum(scene.start + np.arange(count) / frame_rate, scene.end)
    shown, unseen = _seen(scene, times)
    needed = frame_format.frame_bytes * (count * len(scene.static) + shown)
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
            written = write(scene_at(scene, float(seconds)), scene.antialiased)
            (temporary / f"frame_{number:0{max(4, len(str(count - 1)))}}{suffix}").write_bytes(written.data)
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
