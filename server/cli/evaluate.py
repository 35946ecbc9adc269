"""`hgs eval RUN`: scores of a finished run, by default on its held-out cameras."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.base.writable import require_writable_folder
from hgs_core.evaluate.score_table import SCORE_COLUMNS, score_lines
from server.cli.progress_bars import ProgressBars

__all__ = ["add_parser"]

NO_LPIPS = "no LPIPS: give its weights with --lpips FILE; docs/evaluation.md says how to make the file"


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "eval",
        help="measure a finished run",
        description="Measure a finished run, by default on its held-out cameras. eval.json has every frame's scores.",
    )
    parser.add_argument("run_folder", metavar="RUN", type=Path, help="folder of the run")
    parser.add_argument(
        "--truth",
        metavar="FOLDER",
        type=Path,
        help="score against these pictures, <camera>/<FFFF>.png, instead of the capture's",
    )
    parser.add_argument(
        "--masks",
        metavar="FOLDER",
        type=Path,
        help="masks of what moves, <camera>/<FFFF>.png; without it the capture's, or what moves in the true pictures",
    )
    parser.add_argument("--lpips", metavar="WEIGHTS", type=Path, help="compute LPIPS with these weights (.npz)")
    parser.add_argument("--flip", action="store_true", help="compute FLIP (needs the extra eval)")
    parser.add_argument(
        "--magnify",
        metavar="2,4",
        help="also score pictures so many times as large, averaged back, and eyes nearer to what moves",
    )
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--cameras", metavar="A,B", help="score these cameras")
    which.add_argument("--all-cameras", action="store_true", help="score every camera, those trained on too")
    parser.add_argument(
        "--backend", metavar="NAME", default="auto", help="what draws: auto, cpu, triton or reference (default: auto)"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from hgs_core.runs.run_folder import RunFolder

    cameras = None if options.cameras is None else _names(options.cameras)
    magnify = [] if options.magnify is None else _factors(options.magnify)
    RunFolder(options.run_folder).read_spec()  # ahead of loading torch, for a quick refusal
    require_writable_folder(options.run_folder)
    from hgs_core.evaluate.run import evaluate_run

    with ProgressBars() as bars:
        result = evaluate_run(
            options.run_folder,
            bars,
            cameras=cameras,
            all_cameras=options.all_cameras,
            truth=options.truth,
            masks=options.masks,
            lpips=options.lpips,
            flip=options.flip,
            magnify=magnify,
            backend=options.backend,
        )
    scores = {name: result[name] for name in SCORE_COLUMNS}
    if options.lpips is None:
        print(NO_LPIPS, file=sys.stderr)
    if options.json:
        print(json.dumps(scores))
    else:
        print("\n".join(score_lines(scores)))
    return 0


def _names(text: str) -> list[str]:
    names = [name.strip() for name in text.split(",") if name.strip()]
    if not names:
        raise InputError("--cameras", "names no camera", "give names as in --cameras cam00,cam01, or leave it out")
    return names


def _factors(text: str) -> list[int]:
    try:
        return sorted({int(part) for part in text.split(",")})
    except ValueError:
        raise InputError("--magnify", f"{text!r} is not a list of whole numbers", "try --magnify 2,4") from None
