"""Times training iterations on demand: one of the processes of `benchmarks.against.comparison`.

Run as a file by the interpreter of a checkout, so that it measures that checkout's code, which may be older than this
one. Reads one JSON request per line and answers each with a line of JSON.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any
from unittest.mock import patch

from hgs_core.bench.raster.accuracy import errors
from hgs_core.bench.raster.raster_sizes import Size
from hgs_core.bench.raster.stage_times import training_times, using_threads
from hgs_core.bench.raster.workload import Workload

__all__: list[str] = []


def _answer(workload: Workload, request: dict[str, Any]) -> dict[str, float]:
    """Time iterations for `seconds` of processor time, or return the errors against float64."""
    if "seconds" not in request:
        found = errors(workload, ["cpu"])["cpu"]
        return {"image": found.image, **found.gradients}
    # A clock that other programs do not advance, in checkouts too that know no other than this.
    with patch("time.perf_counter", time.process_time):
        return training_times(workload, "cpu", request["seconds"]).median._asdict()


def _serve() -> None:
    start = json.loads(sys.stdin.readline())
    workload = Workload.of(Size(*start["size"]), start["seed"], start["dynamic_share"])
    with using_threads(start["threads"], "cpu"):
        for line in sys.stdin:
            print(json.dumps(_answer(workload, json.loads(line))), flush=True)


if __name__ == "__main__":
    _serve()
