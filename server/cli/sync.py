"""`hgs sync CAPTURE`: by how much the videos of a capture are apart, told by what moves, into sync.json."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.base.progress import StageStopped
from server.cli.interrupts import Interrupts
from server.cli.progress_bars import ProgressBars

if TYPE_CHECKING:
    from hgs_core.capture.capture import Capture

__all__ = ["add_parser"]

_SAME_MOMENT = 1e-4  # seconds


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "sync", help="find out by how much the videos are apart",
        description="Find by what moves when each camera began, to parts of a frame, and write sync.json.",
    )  # fmt: skip
    parser.add_argument("capture", metavar="CAPTURE", type=Path, help="folder of a multi-view video with poses")
    parser.add_argument("--out", metavar="FILE", type=Path, help="where to write (default: CAPTURE/sync.json)")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from hgs_core.capture.open import open_capture
    from hgs_core.capture.sync import SYNC_FILE
    from hgs_core.check.synchronise import find_offsets

    out = options.out or options.capture / SYNC_FILE
    if out.exists():
        raise InputError(out, "is there already", "move it away to have the offsets found again")
    capture = open_capture(options.capture)
    _refuse_aligned(options.capture, capture)
    with Interrupts() as interrupts, ProgressBars(interrupts) as bars:
        try:
            offsets = find_offsets(capture, bars)
        except StageStopped:
            return 130
    names = [camera.name for camera in capture.cameras]
    told = {name: round(offset, 2) + 0.0 for name, offset in zip(names, offsets, strict=True) if offset is not None}
    for name, offset in told.items():
        print(f"{name} {offset:+.2f}")
    untold = [name for name in names if name not in told]
    if untold:
        problem = f"too little that moves is seen by {', '.join(untold)}"
        raise InputError(options.capture, problem, f"write the offsets to {SYNC_FILE} by hand (docs/captures.md)")
    write_bytes(out, json.dumps({"frames": told}, indent=1).encode() + b"\n")
    print(out)
    return 0


def _refuse_aligned(path: Path, capture: Capture) -> None:
    """Refuse a capture whose footage was put in step when it was opened: offsets of what is left would replace that.

    Raises:
        InputError: a camera shows another frame of its own than the capture's, or took it at another time.
    """
    last = len(capture.times) - 1
    for index, camera in enumerate(capture.cameras):
        for frame in (0, last):
            late = capture.moment(index, frame) - float(capture.times[frame])
            if capture.number(index, frame) != frame or abs(late) > _SAME_MOMENT:
                problem = f"the time stamps of camera {camera.name} already say when it began"
                cure = "remove them (docs/captures.md) to have the offsets found by what moves"
                raise InputError(path, problem, cure)
