"""How much sooner several workers finish a job of many segments, and when the first segment can be watched.

    python -m scripts.measure_segments --segments 12 --seconds 5 --workers 1 4

Training is a stand-in that sleeps (tests/jobs/modules/segment_pipeline.py), so that the cores of this machine do not
matter; the queue, the workers, the claims and the publications are real.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

from hgs_core.runs.run_config import RunConfig
from jobs.artifacts.artifact_store import open_store
from jobs.home.home import Home
from jobs.queue.client import JobClient
from jobs.queue.job_request import JobRequest

REPOSITORY = Path(__file__).resolve().parents[1]
MODULES = REPOSITORY / "tests" / "jobs" / "modules"
ITERATIONS = 20


def main() -> None:
    """Measure, and print a line for each number of workers."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--segments", type=int, default=12)
    parser.add_argument("--seconds", type=float, default=5.0, help="that a segment takes")
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 4])
    options = parser.parse_args()
    sys.path.insert(0, str(MODULES))  # the stand-in's modules
    os.environ["PYTHONPATH"] = os.pathsep.join((str(MODULES), str(REPOSITORY)))
    for workers in options.workers:
        first, whole = _measure(workers, options.segments, options.seconds)
        print(
            f"{workers} workers: the first of {options.segments} segments of {options.seconds:g} s is published after "
            f"{first:.1f} s ({first / whole:.3f} of the time), the last after {whole:.1f} s"
        )


def _measure(workers: int, segments: int, seconds: float) -> tuple[float, float]:
    """Return after how many seconds the first segment is published, and the whole scene."""
    with tempfile.TemporaryDirectory() as folder:
        home = replace(Home.at(Path(folder) / "home"), pipeline="segment_pipeline")
        capture = Path(folder) / "capture"
        capture.mkdir()
        (capture / "segments").write_text(str(segments))
        (capture / "pace").write_text(str(seconds / ITERATIONS))
        environment = {**os.environ, **home.environment()}
        command = [sys.executable, "-m", "jobs.worker", "--exit-with-parent"]
        with JobClient(home) as client:
            started = [
                subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment)
                for _ in range(workers)
            ]
            try:
                while len(client.workers()) < workers:
                    time.sleep(0.1)
                return _run(client, capture)
            finally:
                for worker in started:
                    worker.terminate()
                for worker in started:
                    worker.wait()


def _run(client: JobClient, capture: Path) -> tuple[float, float]:
    store, begun = open_store(client.home), time.monotonic()
    job_id = client.submit(JobRequest(capture, RunConfig().changed({"train.iterations": ITERATIONS})))
    first = 0.0
    while True:
        manifest = store.manifest(job_id)
        first = first or (time.monotonic() - begun if manifest else 0.0)
        if manifest and json.loads(manifest).get("live") is None:
            return first, time.monotonic() - begun
        time.sleep(0.05)


if __name__ == "__main__":
    main()
