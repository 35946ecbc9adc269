"""`hgs bench stream`: the start, the seeks and the pauses of viewers on slow lines."""

from __future__ import annotations

import argparse
import asyncio
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from server.cli.json_output import JsonOutput

__all__ = ["add_parts"]


def add_parts(parts: Any) -> None:
    """Add it to the parts of `hgs bench`."""
    stream: argparse.ArgumentParser = parts.add_parser(
        "stream",
        help="what a viewer gets on bad lines",
        description="Serve a scene to viewers without a picture on lines of given rates: "
        "when playing begins, how often it waits, how long seeks take, and what pictures lose meanwhile.",
    )
    _add_scene_and_output(stream)
    stream.add_argument("--seconds", metavar="S", type=float, default=60.0, help="to watch each line (default: 60)")
    stream.set_defaults(run=_run_stream)


def _add_scene_and_output(part: argparse.ArgumentParser) -> None:
    part.add_argument(
        "run_folder",
        metavar="RUN",
        type=Path,
        nargs="?",
        help="a finished run or a scene folder; default: a made-up scene, 0.96 Mbit/s of random bytes",
    )
    part.add_argument("--minutes", metavar="M", type=float, default=1.0, help="of the made-up scene (default: 1)")
    part.add_argument("--json", metavar="FILE", nargs="?", const="-", help="as of hgs bench raster")


def _run_stream(options: argparse.Namespace) -> int:
    seconds, output = _seconds(options.seconds), JsonOutput(options.json)
    from server.bench.bench_scene import made_up_scene, scene_of
    from server.bench.stream_bench import bench_stream, stream_text

    if options.run_folder is None:
        report, _ = asyncio.run(bench_stream(made_up_scene(round(60 * _minutes(options.minutes))), seconds))
    else:
        scene = scene_of(_scene_folder(options.run_folder))
        report, shown = asyncio.run(bench_stream(scene, seconds))
        from hgs_core.bench.codec.partial_pictures import partial_psnr

        # The first time round: later all is there.
        for line, moments in zip(report["lines"], shown, strict=True):
            line["psnr"] = partial_psnr(scene.manifest, scene.chunks, _first_round(moments))
    output.show(report, stream_text(report))
    return 0


def _scene_folder(folder: Path) -> Path:
    return folder / "scene" if (folder / "scene").is_dir() else folder


def _first_round(moments: Any) -> list[Any]:
    first: list[Any] = []
    for time, have in moments:
        if first and time < first[-1][0]:
            break
        first.append((time, have))
    return first


def _seconds(seconds: float) -> float:
    if not 0 < seconds < float("inf"):
        raise InputError("--seconds", f"{seconds} is not a time to watch", "give a number above 0")
    return seconds


def _minutes(minutes: float) -> float:
    if not 1 / 60 <= minutes <= 600:
        raise InputError("--minutes", f"{minutes} is not the length of a scene", "give a number from 1/60 to 600")
    return minutes
