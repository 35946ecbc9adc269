"""Compare the training iteration of this checkout with another's: python -m benchmarks.against CHECKOUT."""

from __future__ import annotations

import argparse
import dataclasses
import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks.against.comparison import compare, interpreter_of
from benchmarks.against.comparison_table import comparison_text
from benchmarks.refusals import refusing
from hgs_core.bench.raster.raster_settings import BenchSettings, parse_threads
from hgs_core.bench.raster.raster_sizes import DEFAULT_SIZES, Size, parse_sizes
from server.cli.json_output import JsonOutput

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the comparison and return the exit status."""
    parser = argparse.ArgumentParser(prog="benchmarks.against", description=__doc__)
    parser.add_argument("checkout", metavar="CHECKOUT", type=Path, help="another checkout, installed")
    parser.add_argument("--json", metavar="FILE", nargs="?", const="-", help="write JSON to FILE or standard output")
    parser.add_argument("--sizes", metavar="LIST", help="splats and pixels, like 20k@676x507,100k@1352x1014")
    parser.add_argument("--threads", metavar="LIST", help="numbers of threads; default: 1 and all")
    parser.add_argument("--truth", metavar="LIST", help="sizes for errors against float64, or none")
    parser.add_argument("--seconds", metavar="S", type=float, default=1.0, help="of processor time (default: 1)")
    parser.add_argument("--dynamic", metavar="SHARE", type=float, default=0.0, help="dynamic splats (default: 0)")
    parser.add_argument("--seed", metavar="N", type=int, default=0, help="seed of the scenes (default: 0)")
    options = parser.parse_args(arguments)
    return refusing(lambda: _run(options))


def _run(options: argparse.Namespace) -> int:
    python = interpreter_of(options.checkout)
    truth: tuple[Size, ...] | None = None
    if options.truth is not None:
        truth = () if options.truth == "none" else parse_sizes("--truth", options.truth)
    settings = BenchSettings.of(
        sizes=DEFAULT_SIZES if options.sizes is None else parse_sizes("--sizes", options.sizes),
        threads=() if options.threads is None else parse_threads("--threads", options.threads),
        backends=("cpu",),
        truth=truth,
        seconds=options.seconds,
        dynamic_share=options.dynamic,
        seed=options.seed,
    )
    output = JsonOutput(options.json)
    found = [compare(settings, python, size, threads) for size in settings.sizes for threads in settings.threads]
    output.show([dataclasses.asdict(one) for one in found], comparison_text(found))
    return 0


if __name__ == "__main__":
    sys.exit(main())
