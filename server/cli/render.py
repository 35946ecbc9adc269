"""`hgs render RUN --out FILM`: draws a scene along a camera path into a film."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.base.writable import require_writable_file, require_writable_folder
from server.cli.frame_rate import frame_rate
from server.cli.progress_bars import ProgressBars

__all__ = ["add_parser"]

_SIZE = re.compile(r"(\d{1,6})x(\d{1,6})")


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "render",
        help="make a film of a scene",
        description="Draw an encoded scene along a camera path into a film: .mp4, .webm, or a folder of PNG pictures.",
    )
    parser.add_argument("source", metavar="RUN|SCENE", type=Path, help="folder of a run, or of an encoded scene")
    parser.add_argument("--out", metavar="FILE|FOLDER", type=Path, required=True, help=".mp4, .webm, or a folder")
    parser.add_argument(
        "--path",
        metavar="PATH",
        default="orbit",
        help="orbit: around the centre (default); cameras: through those of the capture; or a JSON file of key frames",
    )
    parser.add_argument("--size", metavar="WxH", default="1920x1080", help="pixels (default 1920x1080)")
    parser.add_argument("--fps", metavar="N", help="pictures a second, e.g. 25 or 30000/1001 (default: the capture's)")
    parser.add_argument("--alpha", action="store_true", help="no background: for .webm and PNG")
    parser.add_argument("--silent", action="store_true", help="leave out the sound")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from hgs_core.film import FilmFormat, make_film
    from hgs_core.runs.source import encoded_scene

    size, rate = _size(options.size), None if options.fps is None else frame_rate(options.fps)
    folder = FilmFormat.of(options.out) is FilmFormat.PNG_FOLDER
    (require_writable_folder if folder else require_writable_file)(options.out)
    scene = encoded_scene(options.source)
    path = _path(options.path, scene)
    with ProgressBars() as bars:
        make_film(
            scene,
            path,
            options.out,
            size=size,
            rate=rate,
            alpha=options.alpha,
            sound=not options.silent,
            progress=bars,
        )
    print(options.out)
    return 0


def _path(given: str, scene: Path) -> Any:
    from hgs_core.codec import load_manifest
    from hgs_core.film import load_camera_path, orbit_path, rig_path

    ready: dict[str, Callable[..., Any]] = {"orbit": orbit_path, "cameras": rig_path}
    return ready[given](load_manifest(scene)) if given in ready else load_camera_path(Path(given))


def _size(text: str) -> tuple[int, int]:
    found = _SIZE.fullmatch(text)
    if found is None:
        raise InputError("--size", f"{text!r} is no size", "write width x height, e.g. 1920x1080")
    return int(found[1]), int(found[2])
