"""Draw a scene with our viewer and others in headless Chromium: processor time of a frame, PSNR.

Needs npm and Chromium: python -m benchmarks.viewers RUN|FILE.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from tqdm import tqdm

from benchmarks.refusals import refusing
from benchmarks.viewers.viewers_bench import VIEWERS, ViewerPoint, bench_viewers
from benchmarks.viewers.viewers_table import viewer_line, viewers_text
from hgs_core.base.errors import InputError
from hgs_core.bench.raster.raster_sizes import parse_picture_size
from server.cli.json_output import JsonOutput
from server.cli.progress_bars import ProgressBars

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmark and return the exit status."""
    parser = argparse.ArgumentParser(prog="benchmarks.viewers", description=__doc__)
    parser.add_argument("source", metavar="RUN|FILE", type=Path, help="a run, a scene folder or a file of splats")
    parser.add_argument("--json", metavar="FILE", nargs="?", const="-", help="write JSON to FILE or standard output")
    parser.add_argument("--viewers", metavar="LIST", help="like hgs,playcanvas; default: all")
    parser.add_argument("--size", metavar="WxH", default="640x480", help="pixels (default: 640x480)")
    parser.add_argument("--rounds", metavar="N", type=int, default=3, help="of all viewers in turn (default: 3)")
    parser.add_argument("--frames", metavar="N", type=int, default=20, help="of each measurement (default: 20)")
    options = parser.parse_args(arguments)
    return refusing(lambda: _run(options))


def _run(options: argparse.Namespace) -> int:
    for name in ("rounds", "frames"):
        if (number := getattr(options, name)) < 1:
            raise InputError(f"--{name}", f"{number} is too few", "give 1 or more")
    output = JsonOutput(options.json)

    def show(point: ViewerPoint, done: int) -> None:
        tqdm.write(viewer_line(point, done, options.rounds), file=sys.stderr)

    with ProgressBars() as bars:
        report = bench_viewers(
            options.source,
            bars,
            viewers=VIEWERS if options.viewers is None else options.viewers.split(","),
            size=parse_picture_size("--size", options.size),
            rounds=options.rounds,
            frames=options.frames,
            measured_one=show,
        )
    output.show(report.to_json(), viewers_text(report))
    return 0


if __name__ == "__main__":
    sys.exit(main())
