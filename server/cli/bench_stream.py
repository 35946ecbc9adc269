"""`hgs bench stream` and `hgs bench serve`: what viewers get on bad lines, and what many of them cost."""

from __future__ import annotations

import argparse
import asyncio
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from server.cli.json_output import JsonOutput

__all__ = ["add_parts"]


def add_parts(parts: Any) -> None:
    """Add both to the parts of `hgs bench`."""
    stream: argparse.ArgumentParser = parts.add_parser(
        "stream",
        help="what a viewer gets on bad lines",
        description="Serve a scene to viewers without a picture on lines of given rates, with layers and without: "
        "when playing begins, how often it waits, how long seeks take, and what pictures lose meanwhile.",
    )
    stream.add_argument(
        "run_folder", metavar="RUN", type=Path, nargs="?",
        help="a finished run or a scene folder; default: a made-up scene of a minute, 8.1 MB of random bytes",
    )  # fmt: skip
    stream.add_argument("--seconds", metavar="S", type=float, default=60.0, help="to watch each line (default: 60)")
    stream.add_argument("--json", metavar="FILE", nargs="?", const="-", help="as of hgs bench raster")
    stream.set_defaults(run=_run_stream)
    serve: argparse.ArgumentParser = parts.add_parser(
        "serve",
        help="what many viewers cost the server",
        description="Serve a made-up scene to many viewers at once: processor time of the server, starts and stalls.",
    )
    serve.add_argument("--viewers", metavar="N", type=int, default=50, help="at once (default: 50)")
    serve.add_argument("--seconds", metavar="S", type=float, default=10.0, help="to watch (default: 10)")
    serve.add_argument("--json", metavar="FILE", nargs="?", const="-", help="as of hgs bench raster")
    serve.set_defaults(run=_run_serve)


def _run_stream(options: argparse.Namespace) -> int:
    seconds, output = _seconds(options.seconds), JsonOutput(options.json)
    from server.stream_bench import bench_stream, made_up_scene, scene_of, stream_text

    if options.run_folder is None:
        report, _ = asyncio.run(bench_stream(made_up_scene(), seconds))
    else:
        folder: Path = options.run_folder
        scene = scene_of(folder / "scene" if (folder / "scene").is_dir() else folder)
        report, shown = asyncio.run(bench_stream(scene, seconds))
        from hgs_core.bench.partial_pictures import partial_psnr

        # The first time round: later all is there.
        for line, moments in zip(report["lines"], shown, strict=True):
            line["psnr"] = partial_psnr(scene.manifest, scene.chunks, _first_round(moments))
    output.show(report, stream_text(report))
    return 0


def _run_serve(options: argparse.Namespace) -> int:
    if options.viewers < 1:
        raise InputError("--viewers", f"{options.viewers} is too few", "give 1 or more")
    seconds, output = _seconds(options.seconds), JsonOutput(options.json)
    from server.serve_bench import bench_serve, serve_text

    report = bench_serve(options.viewers, seconds)
    output.show(report, serve_text(report))
    return 0


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
