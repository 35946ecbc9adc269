"""`hgs cameras FOLDER`: poses and focal lengths of a rig from its videos alone."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hgs_core.base.errors import InputError
from hgs_core.base.progress import StageStopped, interruptible
from hgs_core.base.writable import require_writable_folder
from server.cli.interrupts import Interrupts
from server.cli.progress_bars import ProgressBars

if TYPE_CHECKING:
    from hgs_core.calibrate.board import Board
    from hgs_core.calibrate.structure import Solution
    from hgs_core.calibrate.upright import Distance

__all__ = ["add_parser"]


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "cameras",
        help="find the poses of cameras from their videos",
        description="Find poses and focal lengths from videos of cameras that stand still, and write them beside the "
        "videos as COLMAP's text files, sparse/0.",
    )
    parser.add_argument("folder", metavar="FOLDER", type=Path, help="one synchronous video of each camera")
    parser.add_argument("--focal", metavar="PIXELS", type=float, help="the focal length of all cameras, if it is known")
    parser.add_argument(
        "--up", metavar="CAMERA", help="a camera whose picture is upright (default: all are held level)"
    )
    parser.add_argument(
        "--distance", metavar="A,B=METRES", help="between two cameras, for the scale (default: an arbitrary one)"
    )
    parser.add_argument(
        "--board",
        metavar="8x5",
        help="a ChArUco board of so many squares is shown to the cameras: metres, and more sure",
    )
    parser.add_argument("--square", metavar="METRES", type=float, help="side of one of its squares")
    parser.add_argument("--marker", metavar="METRES", type=float, help="side of a marker (default: 3/4 of a square)")
    parser.add_argument("--dictionary", default="4X4_50", help="family of its markers (default: 4X4_50)")
    parser.add_argument("--old-board", action="store_true", help="it was made by OpenCV before 4.6")
    parser.add_argument(
        "--floor", action="store_true", help="the board lies on the floor where it is seen first: the floor is y = 0"
    )
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from hgs_core.calibrate.find_cameras import COLMAP_FOLDER, find_cameras

    if options.focal is not None and not 0 < options.focal < 1e6:
        raise InputError("--focal", f"{options.focal} is no focal length", "give it in pixels of the videos")
    distance = None if options.distance is None else _distance(options.distance)
    board = _board(options)
    if options.folder.is_dir():
        _say_where_videos_are(options.folder)
        require_writable_folder(options.folder / COLMAP_FOLDER)
    with Interrupts() as interrupts, ProgressBars(interrupts) as bars, interruptible():
        try:
            solution = find_cameras(
                options.folder,
                focal=options.focal,
                up=options.up,
                distance=distance,
                board=board,
                floor=options.floor,
                progress=bars,
            )
        except StageStopped:
            return 130
    print(_table(solution), file=sys.stderr)
    if distance is None and board is None:
        print("the scale is arbitrary; --distance and --board give metres", file=sys.stderr)
    print(options.folder / COLMAP_FOLDER)
    return 0


def _say_where_videos_are(folder: Path) -> None:
    """Say which folder the videos are taken from, where it is not the one that was given."""
    from hgs_core.calibrate.uncalibrated import find_videos, folder_below

    try:
        place = folder_below(folder, find_videos(folder))
    except InputError:
        return  # finding the cameras says why
    if place is not None:
        print(f"{folder}: has no videos of its own; those of {place} are taken", file=sys.stderr)


def _board(options: argparse.Namespace) -> Board | None:
    """Return the board that the options describe; None without one.

    Raises:
        InputError: the board is not described whole, or options contradict each other.
    """
    from hgs_core.calibrate.board import Board, open_cv

    if options.board is None:
        given = next((name for name in ("square", "marker", "floor") if getattr(options, name)), None)
        if given is not None:
            raise InputError(f"--{given}", "there is no --board", "describe the board: --board 8x5 --square 0.04")
        return None
    columns, cross, rows = options.board.lower().partition("x")
    if not (cross and columns.isascii() and rows.isascii() and columns.isdigit() and rows.isdigit()):
        raise InputError("--board", f"{options.board!r} is no number of squares", "give it as in 8x5")
    if options.square is None:
        raise InputError("--board", "the side of its squares is not given", "add --square METRES, as measured on it")
    if options.distance is not None:
        raise InputError("--distance", "the board says how large the rig is", "give one of them")
    if options.floor and options.up is not None:
        raise InputError("--up", "the board on the floor says what is level", "give one of them")
    marker = 0.75 * options.square if options.marker is None else options.marker
    dictionary = options.dictionary.upper().removeprefix("DICT_")
    board = Board(int(columns), int(rows), options.square, marker, dictionary, options.old_board)
    open_cv()
    return board


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
