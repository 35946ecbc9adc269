"""`hgs cameras FOLDER`: poses and focal lengths of a rig from its videos alone."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hgs_core.base.errors import InputError
from hgs_core.base.progress import StageStopped
from server.cli.interrupts import Interrupts
from server.cli.progress_bars import ProgressBars

if TYPE_CHECKING:
    from hgs_core.calibrate.structure import Solution
    from hgs_core.calibrate.upright import Distance

__all__ = ["add_parser"]


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "cameras", help="find the poses of cameras from their videos",
        description="Find poses and focal lengths from videos of cameras that stand still, and write them beside the "
        "videos as COLMAP's text files, sparse/0.",
    )  # fmt: skip
    parser.add_argument("folder", metavar="FOLDER", type=Path, help="one synchronous video of each camera")
    parser.add_argument("--focal", metavar="PIXELS", type=float, help="the focal length of all cameras, if it is known")
    parser.add_argument(
        "--up", metavar="CAMERA", help="a camera whose picture is upright (default: all are held level)"
    )
    parser.add_argument(
        "--distance", metavar="A,B=METRES", help="between two cameras, for the scale (default: an arbitrary one)"
    )
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from hgs_core.calibrate.find_cameras import COLMAP_FOLDER, find_cameras

    if options.focal is not None and not 0 < options.focal < 1e6:
        raise InputError("--focal", f"{options.focal} is no focal length", "give it in pixels of the videos")
    distance = None if options.distance is None else _distance(options.distance)
    with Interrupts() as interrupts, ProgressBars(interrupts) as bars:
        try:
            solution = find_cameras(
                options.folder, focal=options.focal, up=options.up, distance=distance, progress=bars
            )
        except StageStopped:
            return 130
    print(_table(solution), file=sys.stderr)
    if distance is None:
        print("the scale is arbitrary; --distance gives metres", file=sys.stderr)
    print(options.folder / COLMAP_FOLDER)
    return 0


def _table(solution: Solution) -> str:
    width = max(len(camera.name) for camera in solution.cameras)
    lines = [f"{'camera':<{max(6, width)}}  focal px  points"]
    lines += [
        f"{camera.name:<{max(6, width)}}  {camera.parameters[0]:8.1f}  {camera.observations:6,}"
        for camera in solution.cameras
    ]
    return "\n".join([*lines, f"{solution.error:.2f} px on average"])


def _distance(text: str) -> Distance:
    from hgs_core.calibrate.upright import Distance

    names, equals, metres = text.rpartition("=")
    first, comma, second = names.partition(",")
    try:
        value = float(metres)
    except ValueError:
        value = 0.0
    if not (equals and comma and first.strip() and second.strip() and 0 < value < 1e9):
        raise InputError("--distance", f"{text!r} is not A,B=METRES", "give it as in cam00,cam05=3.2")
    return Distance(first.strip(), second.strip(), value)
