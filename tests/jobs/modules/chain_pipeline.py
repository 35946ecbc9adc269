"""A pipeline with iterations that depend on all before: its scene shows a lost or repeated one.

An iteration hashes what the last one left; a checkpoint every five holds how many there were and the hash. Every
iteration leaves a line with its process id and number in the capture, which all machines share: no part of the run.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import time
from pathlib import Path

from scene_folder import write_scene

from hgs_core.base.atomic import write_bytes
from hgs_core.base.progress import Progress, ProgressCallback, StageStopped
from hgs_core.runs.given_files import GivenFiles
from hgs_core.runs.run_config import RunConfig
from tests.chunks import static_chunk

CHECKPOINT_EVERY = 5
SECONDS_PER_ITERATION = 0.02


def chain(iterations: int) -> bytes:
    """Return the chunk of a training that nothing disturbed."""
    state = b""
    for iteration in range(iterations):
        state = _next(state, iteration)
    return static_chunk(state)


def create_run(run: Path, capture: Path, config: RunConfig, given: GivenFiles) -> RunConfig:
    settings = {"capture": str(capture), "iterations": config.train.iterations}
    write_bytes(run / "run.json", json.dumps(settings).encode())
    return config


def initialise(run: Path, progress: ProgressCallback) -> None:
    progress(Progress("initialise", 1, 1))
    write_bytes(run / "points.npz", b"points")


def train(run: Path, progress: ProgressCallback) -> None:
    settings = json.loads((run / "run.json").read_text())
    iterations, log = settings["iterations"], Path(settings["capture"]) / f"{run.name}.log"
    assert (run / "points.npz").read_bytes() == b"points"
    done, state = _load(run)
    for iteration in range(done, iterations):
        try:
            progress(Progress("train", iteration, iterations, {"loss": 1 / (iteration + 1)}))
        except StageStopped:
            _save(run, iteration, state)
            raise
        time.sleep(SECONDS_PER_ITERATION)
        state = _next(state, iteration)
        # In the sandbox of a home without a store it cannot write to its capture.
        with contextlib.suppress(PermissionError), log.open("a") as file:
            file.write(f"{os.getpid()} {iteration}\n")
        if (iteration + 1) % CHECKPOINT_EVERY == 0:
            _save(run, iteration + 1, state)
    _save(run, iterations, state)
    progress(Progress("train", iterations, iterations, {"loss": 0.0}))
    write_bytes(run / "train.json", b"{}")


def encode(run: Path, progress: ProgressCallback) -> None:
    write_scene(run / "scene", (static_chunk(_load(run)[1]),))
    progress(Progress("encode", 1, 1))


def _next(state: bytes, iteration: int) -> bytes:
    return hashlib.sha256(state + str(iteration).encode()).digest()


def _load(run: Path) -> tuple[int, bytes]:
    checkpoint = run / "checkpoint.pt"
    if not checkpoint.exists():
        return 0, b""
    done, state = checkpoint.read_text().split(" ")
    return int(done), bytes.fromhex(state)


def _save(run: Path, done: int, state: bytes) -> None:
    write_bytes(run / "checkpoint.pt", f"{done} {state.hex()}".encode())
