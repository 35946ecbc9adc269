"""A stand-in for training by segments: each counts to `config.train.iterations`, of the capture's `pace` seconds.

There are as many segments as the capture's file `segments` says. Whoever begins one leaves a line in `begun.log`, every
iteration one in `iterations.log`, and a segment that is made one in `made.log`. They go on from their checkpoints, and
all but the first wait while there is a file `hold` in the run folder.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from pathlib import Path
from sys import modules
from types import ModuleType

from hgs_core.base.atomic import write_bytes
from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.runs.given_files import GivenFiles
from hgs_core.runs.run_config import RunConfig
from tests.chunks import dynamic_chunk, static_chunk
from tests.growing import growing_manifest


def create_run(run: Path, capture: Path, config: RunConfig, given: GivenFiles) -> RunConfig:
    run.mkdir(parents=True, exist_ok=True)
    numbers = {name: float((capture / name).read_text()) for name in ("segments", "pace")}
    write_bytes(run / "run.json", json.dumps(numbers | {"iterations": config.train.iterations}).encode())
    return config


def initialise(run: Path, progress: ProgressCallback) -> None:
    progress(Progress("initialise", 1, 1))


def encode(run: Path, progress: ProgressCallback) -> None:
    progress(Progress("encode", 1, 1))


def segments_of(run: Path) -> ModuleType:
    return modules[__name__]


def segment_count(run: Path) -> int:
    return int(_settings(run)["segments"])


def made(run: Path, number: int) -> bool:
    return (run / "segments" / str(number)).exists()


def make_segment(run: Path, number: int, progress: ProgressCallback) -> None:
    iterations, checkpoint = int(_settings(run)["iterations"]), run / "segments" / f"{number}.checkpoint"
    done = int(checkpoint.read_text()) if checkpoint.exists() else 0
    _note(run / "begun.log", f"{number} {os.getppid()}")
    for iteration in range(done, iterations):
        while number and (run / "hold").exists():
            progress(Progress("train", iteration, iterations))
            time.sleep(0.02)
        progress(Progress("train", iteration, iterations))
        time.sleep(_settings(run)["pace"])
        _note(run / "iterations.log", f"{number} {iteration}")
        write_bytes(checkpoint, str(iteration + 1).encode())
    _note(run / "made.log", str(number))
    write_bytes(run / "segments" / str(number), b"segment %d" % number)


def assemble(run: Path) -> int:
    count = 0
    while made(run, count):
        count += 1
    _write(run, count, live=True)
    return count


def finish(run: Path, progress: ProgressCallback) -> None:
    _write(run, segment_count(run), live=False)


def _settings(run: Path) -> dict[str, float]:
    settings: dict[str, float] = json.loads((run / "run.json").read_text())
    return settings


def _note(log: Path, line: str) -> None:
    with log.open("a") as file:
        file.write(line + "\n")


def _write(run: Path, count: int, *, live: bool) -> None:
    static = static_chunk(b"room")
    moving = [dynamic_chunk((run / "segments" / str(k)).read_bytes(), (float(k), k + 1.0)) for k in range(count)]
    for data in (static, *moving):
        write_bytes(run / "scene" / "chunks" / hashlib.sha256(data).hexdigest(), data)
    manifest = growing_manifest(static, moving, count if live else None)
    write_bytes(run / "scene" / "manifest.json", json.dumps(manifest.to_json()).encode())
