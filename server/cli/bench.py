"""`hgs bench`: speed and error of rasterizers, codec, trainings and streams on this machine."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.bench.raster.raster_settings import BenchSettings, parse_backends, parse_threads
from hgs_core.bench.raster.raster_sizes import DEFAULT_SIZES, Size, parse_sizes
from server.cli.bench_stream import add_parts
from server.cli.json_output import JsonOutput
from server.cli.progress_bars import ProgressBars
from server.cli.training_options import add_training_options, training_config

__all__ = ["add_parser"]


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "bench", help="measure speed and error", description="Measure the parts of HGS on this machine."
    )
    parts = parser.add_subparsers(metavar="PART", required=True)
    raster: argparse.ArgumentParser = parts.add_parser(
        "raster",
        help="the rasterizers",
        description="Measure how fast the rasterizers train on synthetic scenes and how far they are from float64.",
    )
    raster.add_argument(
        "--json",
        metavar="FILE",
        nargs="?",
        const="-",
        help="write JSON to FILE, or to standard output in place of text",
    )
    raster.add_argument("--sizes", metavar="LIST", help="splats and pixels, like 20k@676x507,100k@1352x1014")
    raster.add_argument("--threads", metavar="LIST", help="numbers of threads; default: 1 and all")
    raster.add_argument("--backends", metavar="LIST", help="cpu, reference or both; default: both")
    raster.add_argument(
        "--truth",
        metavar="LIST",
        help="sizes at which the torch path and float64 run too, or none; they take seconds and gigabytes; "
        "default: up to 20k@676x507",
    )
    raster.add_argument("--seconds", metavar="S", default="1", help="of timing per point (default: 1)")
    raster.add_argument("--dynamic", metavar="SHARE", default="0", help="share of splats that move (default: 0)")
    raster.add_argument("--seed", metavar="N", default="0", help="of the scenes (default: 0)")
    raster.set_defaults(run=_run)
    codec: argparse.ArgumentParser = parts.add_parser(
        "codec",
        help="the scene format",
        description="Encode a run or a file of splats by budgets and coarsenesses: bytes, loss, rates, other formats.",
    )
    codec.add_argument(
        "source", metavar="RUN|FILE", type=Path, help="a finished run, or a .ply, .splat, .spz or .glb file"
    )
    codec.add_argument(
        "--json",
        metavar="FILE",
        nargs="?",
        const="-",
        help="write JSON to FILE, or to standard output in place of text; in RUN/codec.json hgs report shows it",
    )
    codec.add_argument("--sweep", metavar="LIST", help="coarsenesses to encode with, like 0.5,1,2, or none")
    codec.set_defaults(run=_run_codec)
    train: argparse.ArgumentParser = parts.add_parser(
        "train", help="a whole training", description="Train a capture in a temporary folder: minutes and PSNR."
    )
    train.add_argument("capture", metavar="CAPTURE", type=Path, help="folder of a multi-view capture")
    train.add_argument("--device", choices=("cpu", "cuda"), default="cpu", help="what trains (default: cpu)")
    train.add_argument("--json", metavar="FILE", nargs="?", const="-", help="as of hgs bench raster")
    add_training_options(train, hold_out="")
    train.set_defaults(run=_run_training)
    add_parts(parts)


def _run(options: argparse.Namespace) -> int:
    settings = BenchSettings.of(
        sizes=DEFAULT_SIZES if options.sizes is None else parse_sizes("--sizes", options.sizes),
        threads=() if options.threads is None else parse_threads("--threads", options.threads),
        backends=() if options.backends is None else parse_backends("--backends", options.backends),
        truth=_truth(options.truth),
        seconds=_number("--seconds", options.seconds),
        dynamic_share=_number("--dynamic", options.dynamic),
        seed=_whole("--seed", options.seed),
    )
    output = JsonOutput(options.json)
    from hgs_core.bench.raster.raster_bench import bench_raster
    from hgs_core.bench.raster.raster_table import report_text

    with ProgressBars() as bars:
        report = bench_raster(settings, bars)
    output.show(report.to_json(), report_text(report))
    return 0


def _run_codec(options: argparse.Namespace) -> int:
    output = JsonOutput(options.json)
    from hgs_core.bench.codec.codec_bench import SWEEP, bench_codec
    from hgs_core.bench.codec.codec_table import codec_text

    sweep: tuple[float, ...] = SWEEP
    if options.sweep is not None:
        sweep = () if options.sweep == "none" else tuple(map(_coarseness, options.sweep.split(",")))
    with ProgressBars() as bars:
        report = bench_codec(options.source, bars, budgets=("default", "low"), sweep=sweep)
    output.show(report.to_json(), codec_text(report))
    return 0


def _run_training(options: argparse.Namespace) -> int:
    config, output = training_config(options), JsonOutput(options.json)
    from hgs_core.bench.training_bench import bench_training, training_report_text

    with ProgressBars() as bars:
        report = bench_training(options.capture, config, options.device, bars)
    output.show(report.to_json(), training_report_text(report))
    return 0


def _truth(text: str | None) -> tuple[Size, ...] | None:
    if text is None:
        return None
    return () if text == "none" else parse_sizes("--truth", text)


def _coarseness(text: str) -> float:
    value = _number("--sweep", text)
    if not 0 < value < math.inf:
        raise InputError("--sweep", f"{text} is no coarseness", "give numbers above 0, such as 0.5,1,2")
    return value


def _number(where: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(where, f"{text!r} is not a number") from None


def _whole(where: str, text: str, least: int = 0) -> int:
    if not (text.isascii() and text.isdecimal() and len(text) < 10) or int(text) < least:
        raise InputError(where, f"{text[:40]!r} is not a whole number from {least}")
    return int(text)
