"""`hgs edit RUN --out NEW`: a new run of a scene that is cropped, trimmed, cleaned, turned or merged with another."""

from __future__ import annotations

import argparse
import functools
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from hgs_core.base.errors import InputError
from hgs_core.base.writable import require_writable_folder
from hgs_core.edit.crop import crop
from hgs_core.edit.floaters import drop_floaters
from hgs_core.edit.orient import Similarity, orient, turn_about, turn_up
from hgs_core.edit.regions import Region, ball_of, box_of
from hgs_core.edit.splat_list import SplatList
from hgs_core.edit.trim import trim
from hgs_core.edit.viewed_scene import Edit, ViewedScene
from hgs_core.fit.fit_config import BUDGETS
from server.cli.json_output import JsonOutput
from server.cli.progress_bars import ProgressBars

__all__ = ["add_parser"]

Step = Callable[[ViewedScene], Edit]
IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "edit",
        help="crop, trim, turn, clean or merge scenes",
        description="Make a new run of another: without listed splats, trimmed, cropped, without floaters, turned, "
        "merged, in this order. The first run stays as it is. Write numbers with =, as in --box=0,-1,0,2,2,2.",
    )
    add = parser.add_argument
    add("source", metavar="RUN|SCENE", type=Path, help="folder of a run, or of an encoded scene")
    add("--out", metavar="NEW", type=Path, required=True, help="new folder of the edited run")
    add("--splats", metavar="FILE", type=Path, help="leave out the splats of a list, made on the scene's page")
    add("--trim", metavar="START,END", help="seconds of the scene's clock; START becomes 0")
    add("--box", metavar="X,Y,Z,W,H,D[,QW,QX,QY,QZ]", help="keep what is inside: its middle, whole sides and turn")
    add("--sphere", metavar="X,Y,Z,R", help="keep what is inside: its middle and radius")
    add("--inverse", action="store_true", help="keep what is outside of the box or sphere")
    add("--touching", action="store_true", help="keep moving splats that cross its border, too")
    add("--drop-floaters", action="store_true", help="leave out splats that stand alone")
    add("--up", metavar="X,Y,Z", help="turn the scene so that this direction points up")
    add("--rotate", metavar="X,Y,Z,DEGREES", help="turn the scene about an axis through the origin")
    add("--scale", metavar="FACTOR", help="make it larger or smaller about the origin")
    add("--translate", metavar="X,Y,Z", help="move it, world units")
    add("--merge", metavar="RUN|SCENE", type=Path, help="add another scene, which lies in the same world")
    add("--at", metavar="S", help="with --merge: the second at which the other scene begins; default: with this one")
    add("--budget", choices=list(BUDGETS), default="default", help="what encoding may lose")
    add("--json", metavar="FILE", help="write what is left out or changed as JSON; -: in place of text")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    output = JsonOutput(options.json)
    steps = _steps(options)
    splats = None if options.splats is None else SplatList.load(options.splats)
    require_writable_folder(options.out)
    from hgs_core.runs.edited import edit_run

    with ProgressBars() as bars:
        edited = edit_run(options.source, options.out, steps, bars, options.budget, splats)
    for change in edited.changes:
        print(f"{options.source}: {change}", file=sys.stderr)
    output.show({"run": str(options.out), **edited.to_json()}, str(options.out))
    return 0


def _steps(options: argparse.Namespace) -> list[Step]:
    """Return the requested edits, in order.

    Raises:
        InputError: an option is malformed, lacks the one that it belongs to, or there is nothing to do.
    """
    steps: list[Step] = []
    if options.trim is not None:
        start, end = _numbers("--trim", options.trim, 2)
        steps.append(functools.partial(trim, start=start, end=end))
    regions: list[Region] = [box_of(_numbers("--box", options.box))] if options.box is not None else []
    regions += [ball_of(_numbers("--sphere", options.sphere))] if options.sphere is not None else []
    for name in ("inverse", "touching"):
        if getattr(options, name) and not regions:
            raise InputError(f"--{name}", "needs --box or --sphere", "give one, or leave it out")
    for region in regions:
        steps.append(functools.partial(crop, region=region, inverse=options.inverse, touching=options.touching))
    if options.drop_floaters:
        steps.append(drop_floaters)
    if any(given is not None for given in (options.up, options.rotate, options.scale, options.translate)):
        steps.append(functools.partial(orient, change=_similarity(options), up=options.up is not None))
    if options.merge is not None:
        at = None if options.at is None else _numbers("--at", options.at, 1)[0]
        steps.append(functools.partial(_merge, options.merge, at))
    elif options.at is not None:
        raise InputError("--at", "needs --merge", "name the other scene, or leave it out")
    if not steps and options.splats is None:
        raise InputError("hgs edit", "has nothing to do", "see hgs edit --help")
    return steps


def _similarity(options: argparse.Namespace) -> Similarity:
    change = Similarity(IDENTITY, 1.0, np.zeros(3))
    if options.up is not None:
        change = change.then(Similarity(turn_up(_numbers("--up", options.up)), 1.0, np.zeros(3)))
    if options.rotate is not None:
        change = change.then(Similarity(turn_about(_numbers("--rotate", options.rotate)), 1.0, np.zeros(3)))
    if options.scale is not None:
        change = change.then(Similarity(IDENTITY, _numbers("--scale", options.scale, 1)[0], np.zeros(3)))
    if options.translate is not None:
        change = change.then(Similarity(IDENTITY, 1.0, np.array(_numbers("--translate", options.translate, 3))))
    return change


def _merge(path: Path, at: float | None, viewed: ViewedScene) -> Edit:
    from hgs_core.edit.merge import merge
    from hgs_core.runs.edited import open_editable

    return merge(viewed, open_editable(path).viewed, at)


def _numbers(option: str, text: str, count: int | None = None) -> list[float]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if not numbers or not np.isfinite(numbers).all() or (count is not None and len(numbers) != count):
        wanted = "numbers with commas between them" if count is None else f"{count} of them"
        raise InputError(option, f"{text!r} are no finite numbers", f"give {wanted}")
    return numbers
