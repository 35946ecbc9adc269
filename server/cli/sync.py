"""`hgs sync CAPTURE`: the offsets between the videos of a capture, found by sound or motion, into sync.json."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hgs_core.base.errors import InputError
from hgs_core.base.progress import ProgressCallback, StageStopped, interruptible
from hgs_core.base.writable import require_writable_file
from hgs_core.capture.capture_config import SYNC_BY
from server.cli.interrupts import Interrupts
from server.cli.progress_bars import ProgressBars

if TYPE_CHECKING:
    from hgs_core.capture.capture import Capture
    from hgs_core.check.starts import Starts

__all__ = ["add_parser"]

_SAME_MOMENT = 1e-4  # seconds


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "sync",
        help="find out by how much the videos are apart",
        description="Find by their sound or by what moves when each camera began, to parts of a frame, and write "
        "sync.json.",
    )
    parser.add_argument("capture", metavar="CAPTURE", type=Path, help="folder of a multi-view video")
    parser.add_argument(
        "--by",
        choices=SYNC_BY[:-1],
        default=SYNC_BY[0],
        help="the sound of the videos, which needs no poses; what moves, which does; or auto: the sound if it tells",
    )
    parser.add_argument("--out", metavar="FILE", type=Path, help="where to write (default: CAPTURE/sync.json)")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from hgs_core.capture.time.sync import SYNC_FILE

    out = options.out or options.capture / SYNC_FILE
    if out.exists():
        raise InputError(out, "is there already", "move it away to have the offsets found again")
    if options.out is not None or options.capture.is_dir():  # else it is said that there is no such capture
        require_writable_file(out)
    with Interrupts() as interrupts, ProgressBars(interrupts) as bars, interruptible():
        try:
            starts = _starts(options.capture, options.by, bars)
        except StageStopped:
            return 130
    print("\n".join(starts.lines()))
    starts.write(out)
    print(out)
    return 0


def _starts(path: Path, by: str, progress: ProgressCallback) -> Starts:
    from hgs_core.calibrate.uncalibrated import find_videos, has_poses
    from hgs_core.capture.open import open_capture
    from hgs_core.check.starts import starts_by_motion, starts_by_sound

    if by == "audio" and path.is_dir() and not has_poses(path):
        videos = find_videos(path)
        return starts_by_sound(path, list(videos), list(videos.values()), progress)
    capture = open_capture(path)
    _refuse_aligned(path, capture)
    if by == "audio" and not capture.unaligned:
        raise InputError(path, "its pictures are no videos and have no sound", "go by what moves: --by motion")
    if by != "motion" and capture.unaligned:
        try:
            return starts_by_sound(path, [camera.name for camera in capture.cameras], capture.unaligned, progress)
        except InputError as error:
            if by == "audio":
                raise
            print(f"{error.problem}: what moves is asked", file=sys.stderr)
    return starts_by_motion(capture, progress)


def _refuse_aligned(path: Path, capture: Capture) -> None:
    """Refuse a capture that was put in step when it was opened: offsets of the rest would replace those.

    Raises:
        InputError: a camera shows another frame of its own than the capture's, or took it at another time.
    """
    last = len(capture.times) - 1
    for index, camera in enumerate(capture.cameras):
        late = max(abs(capture.moment(index, frame) - float(capture.times[frame])) for frame in (0, last))
        # A frame that is missing later on is no other beginning.
        if capture.number(index, 0) != 0 or late > _SAME_MOMENT:
            problem = f"the time stamps of camera {camera.name} already say when it began"
            cure = "remove them (docs/captures.md) to have the offsets found again"
            raise InputError(path, problem, cure)
