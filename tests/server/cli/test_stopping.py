"""`hgs train` stopped by SIGTERM and SIGINT in each of its stages: it reports the stop, keeps its work, and resumes."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from hgs_core.codec.format.scene_folder import MANIFEST, load_manifest
from tests.conftest import REPOSITORY

STAGES = ("check", "frames", "masks", "points", "train", "encode")
SETTINGS = ("--preset", "preview", "--hold-out", "2", "--trust-poses", "--set", "train.iterations=60")
SAYS = "stopped; run the same command again to resume"

# Runs the command again and again in one process, which signals itself at the first report of the stage's second step.
STOPS_ITSELF = """
import json, os, signal, sys
from pathlib import Path
from server.cli import main
from server.cli.progress_bars import ProgressBars
capture, out, *settings = sys.argv[1:]
report, asked = ProgressBars.__call__, []

def signalled(self, progress):
    begun = progress.done > 0 or progress.stage in ("frames", "masks", "check")
    if asked and progress.stage == asked[0][0] and begun:
        os.kill(os.getpid(), asked.pop()[1])
    report(self, progress)

ProgressBars.__call__ = signalled
for stage in ("check", "frames", "masks", "points", "train", "encode"):
    for number in (signal.SIGTERM, signal.SIGINT):
        asked.append((stage, number))
        status = main(["train", capture, "--out", out, *settings])
        files = {str(path.relative_to(out)): path.stat().st_mtime_ns for path in Path(out).rglob("*") if path.is_file()}
        print(json.dumps({"stage": stage, "status": status, "asked": len(asked), "files": files}), flush=True)
print(json.dumps({"stage": "", "status": main(["train", capture, "--out", out, *settings])}))
"""


def arguments(capture: Path, out: Path) -> list[str]:
    return [str(capture), str(out), *SETTINGS]


@pytest.mark.slow
def test_every_stage_can_be_stopped_and_goes_on(capture: Path, tmp_path: Path) -> None:
    out = tmp_path / "run"
    ended = subprocess.run(
        [sys.executable, "-c", STOPS_ITSELF, *arguments(capture, out)],
        cwd=REPOSITORY,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr
    told = [json.loads(line) for line in ended.stdout.splitlines() if line.startswith("{")]
    assert [one["stage"] for one in told] == [stage for stage in STAGES for _ in range(2)] + [""]
    assert [one["status"] for one in told] == [130] * (2 * len(STAGES)) + [0]
    assert not any(one.get("asked") for one in told)
    assert ended.stderr.count(SAYS) == 2 * len(STAGES)
    for words in ("Traceback", "Aborted", "stack trace"):
        assert words not in ended.stderr
    kept = {name: {one["files"].get(name) for one in told if "files" in one} - {None} for name in told[-2]["files"]}
    for name in ("check.json", "masks/0.masks", "points/near.json", "train.json", "scene.npz"):
        assert len(kept[name]) == 1, f"{name} was made again"
    assert "checkpoint.pt" in told[2 * STAGES.index("train")]["files"]
    assert json.loads((out / "train.json").read_text())["iterations"] == 60
    assert not list(out.glob(".*.tmp"))


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
@pytest.mark.parametrize("stage", STAGES)
def test_a_process_that_is_told_to_stop_ends_in_order(
    capture: Path, tmp_path: Path, stage: str, number: signal.Signals
) -> None:
    command = [sys.executable, "-m", "server.cli", "train", str(capture), "--out", str(tmp_path / "run"), *SETTINGS]
    with subprocess.Popen(
        command, cwd=REPOSITORY, stderr=subprocess.PIPE, env={**os.environ, "PYTHONUNBUFFERED": "1"}
    ) as process:
        assert process.stderr is not None
        told = b""
        while f"\r{stage}".encode() not in told.replace(b"\n", b"\r"):
            piece = os.read(process.stderr.fileno(), 4096)
            assert piece, told.decode()
            told += piece
        process.send_signal(number)
        told += process.stderr.read()
    assert process.returncode == 130, told.decode()
    assert SAYS in told.decode()
    for words in (b"Traceback", b"Aborted", b"stack trace"):
        assert words not in told
    again = subprocess.run(command, cwd=REPOSITORY, capture_output=True, check=False)
    assert again.returncode == 0, again.stderr.decode()


def made(out: Path) -> dict[str, bytes | int]:
    """Bytes of every lasting file of a run; of those that state how long it took, the iterations alone."""
    names = [*out.glob("masks/*"), *out.glob("scene/**/*"), out / "points.npz", out / "scene.npz"]
    files: dict[str, bytes | int] = {
        str(path.relative_to(out)): path.read_bytes() for path in names if path.is_file() and path.name != MANIFEST
    }
    manifest = load_manifest(out / "scene")
    return files | {
        "chunks": "".join(entry.id for entry in manifest.chunks).encode(),
        "iterations": json.loads((out / "train.json").read_text())["iterations"],
    }


@pytest.mark.slow
def test_a_training_killed_at_ten_random_moments_ends_in_the_same_bits(capture: Path, tmp_path: Path) -> None:
    dice = random.Random(36)
    command = [
        sys.executable,
        "-m",
        "server.cli",
        "train",
        str(capture),
        *SETTINGS,
        "--set",
        "train.checkpoint_every=7",
    ]
    whole, killed = (tmp_path / name for name in ("whole", "killed"))
    subprocess.run([*command, "--out", str(whole)], cwd=REPOSITORY, capture_output=True, check=True)
    reached = []
    for stage in sorted(dice.choices(STAGES, k=10), key=STAGES.index):
        with subprocess.Popen([*command, "--out", str(killed)], cwd=REPOSITORY, stderr=subprocess.PIPE) as process:
            assert process.stderr is not None
            told = b""
            while f"\r{stage}".encode() not in told.replace(b"\n", b"\r") and (
                piece := os.read(process.stderr.fileno(), 4096)
            ):
                told += piece
            time.sleep(dice.uniform(0.0, 1.5))
            process.kill()
        reached.append((stage, process.returncode))
    subprocess.run([*command, "--out", str(killed)], cwd=REPOSITORY, capture_output=True, check=True)
    assert sum(status == -signal.SIGKILL for _, status in reached) >= 5, reached
    assert made(killed) == made(whole)
