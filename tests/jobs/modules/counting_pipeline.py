"""A pipeline that counts to `config.train.iterations`: it checkpoints, resumes, stops and fails like the real one.

The capture is a folder; the file `behaviour` in it says how the training goes: "count", "raise", "bad input", "die" (by
SIGKILL at half-time), "die once", "hang once" (stopped at half-time), "memory" (wants too much of it at half-time),
"hog" (takes 16 GiB of it bit by bit at half-time), "open" (opens 100,000 files at half-time), "threads" (starts 40 that
sleep at half-time, and sleeps), "spy" (reads the file that `elsewhere` names at half-time), "fork" (starts 500
processes that sleep at half-time, of which every second one leaves the session, and sleeps), "leave" (starts one at
half-time that leaves the session and loses its parent, and goes on), "full once" (meets a full disk at half-time),
"compute" (at half-time without a word until there is a file `enough` in the run folder), or "deaf" (ignores SIGTERM and
keeps no checkpoint). `sleepers` in the run folder names the processes. Every iteration appends its process id and
number to `iterations.log` in the run folder.
"""

from __future__ import annotations

import errno
import json
import os
import signal
import subprocess
import threading
import time
from pathlib import Path

import numpy as np
from scene_folder import write_scene

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, ProgressCallback, StageStopped
from hgs_core.runs.given_files import GivenFiles
from hgs_core.runs.run_config import RunConfig
from tests.chunks import static_chunk

CHECKPOINT_EVERY = 5
SECONDS_PER_ITERATION = 0.02


def create_run(run: Path, capture: Path, config: RunConfig, given: GivenFiles | None = None) -> RunConfig:
    if not (capture / "behaviour").is_file():
        raise InputError(capture, "has no file `behaviour`")
    run.mkdir(parents=True, exist_ok=True)
    _replace(run / "run.json", json.dumps({"capture": str(capture), "iterations": config.train.iterations}))
    return config


def initialise(run: Path, progress: ProgressCallback) -> None:
    print("a library that prints to stdout")
    progress(Progress("initialise", 1, 1))
    (run / "points.npz").touch()


def train(run: Path, progress: ProgressCallback) -> None:
    settings = json.loads((run / "run.json").read_text())
    behaviour = (Path(settings["capture"]) / "behaviour").read_text()
    iterations = settings["iterations"]
    checkpoint = run / "checkpoint.pt"
    done = int(checkpoint.read_text()) if checkpoint.exists() else 0
    if behaviour == "deaf":
        progress(Progress("train", 0, iterations))
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
    for iteration in range(done, iterations):
        try:
            progress(Progress("train", iteration, iterations, {"loss": 1 / (iteration + 1)}))
        except StageStopped:
            _replace(checkpoint, str(iteration))
            raise
        time.sleep(SECONDS_PER_ITERATION)
        with (run / "iterations.log").open("a") as log:
            log.write(f"{os.getpid()} {iteration}\n")
        if (iteration + 1) % CHECKPOINT_EVERY == 0 and behaviour != "deaf":
            _replace(checkpoint, str(iteration + 1))
        if iteration == iterations // 2:
            _misbehave(behaviour, run)
    progress(Progress("train", iterations, iterations, {"loss": 0.0}))
    _replace(run / "train.json", "{}")


def encode(run: Path, progress: ProgressCallback) -> None:
    write_scene(run / "scene", (static_chunk((run / "iterations.log").read_bytes()),))
    progress(Progress("encode", 1, 1))


def living_sleepers(run: Path) -> list[str]:
    """Return which of the processes that "fork" or "leave" started are alive."""

    def is_one(pid: str) -> bool:
        try:
            return b"sleep" in Path("/proc", pid, "cmdline").read_bytes()  # nothing, of one that has ended
        except OSError:
            return False

    return [pid for pid in (run / "sleepers").read_text().split() if is_one(pid)]


def _misbehave(behaviour: str, run: Path) -> None:
    if behaviour == "raise":
        raise RuntimeError("the loss is\nnot a number")
    if behaviour == "bad input":
        raise InputError(run, "frame 3 of camera cam01 is missing", "add it")
    if behaviour == "die" or (behaviour == "die once" and not (run / "died").exists()):
        (run / "died").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    if behaviour == "memory":
        np.zeros(1 << 60, np.uint8)
    if behaviour == "hog":  # takes pages that it never touches, so that the test takes none
        taken = [np.empty(1 << 26, np.uint8) for _ in range(256)]
        raise AssertionError(f"{len(taken) << 26} bytes were given")
    if behaviour == "hang once" and not (run / "hung").exists():
        (run / "hung").touch()
        os.kill(os.getpid(), signal.SIGSTOP)
    if behaviour == "full once" and not (run / "full").exists():
        (run / "full").touch()
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(run / "checkpoint.pt"))
    if behaviour == "spy":
        capture = Path(json.loads((run / "run.json").read_text())["capture"])
        Path((capture / "elsewhere").read_text()).read_bytes()
    if behaviour == "open":
        opened = [os.open(os.devnull, os.O_RDONLY) for _ in range(100_000)]
        raise AssertionError(f"{len(opened)} files were opened")
    if behaviour == "threads":
        for _ in range(40):
            threading.Thread(target=time.sleep, args=(1000,), daemon=True).start()
        time.sleep(1000)
    if behaviour in ("fork", "leave"):
        started = [_sleeper(number) for number in range(500)] if behaviour == "fork" else [_orphan()]
        (run / "sleepers").write_text(" ".join(map(str, started)))
        while behaviour == "fork":
            time.sleep(1)
    while behaviour == "compute" and not (run / "enough").exists():
        pass


def _sleeper(number: int) -> int:
    return subprocess.Popen(["sleep", "1000"], start_new_session=number % 2 == 0).pid


def _orphan() -> int:
    command = "setsid sleep 1000 >/dev/null 2>&1 & echo $!"
    return int(subprocess.check_output(["sh", "-c", command]))


def _replace(path: Path, text: str) -> None:
    temporary = path.with_suffix(".tmp")
    temporary.write_text(text)
    temporary.replace(path)
