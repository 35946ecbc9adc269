"""A pipeline with finished scenes as captures: it only copies them."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.runs.given_files import GivenFiles
from hgs_core.runs.run_config import RunConfig


def create_run(run: Path, capture: Path, config: RunConfig, given: GivenFiles) -> RunConfig:
    if not (capture / "scene").is_dir():
        raise InputError(capture, "has no scene")
    run.mkdir(parents=True, exist_ok=True)
    (run / "run.json").write_text(json.dumps({"capture": str(capture)}))
    return config


def initialise(run: Path, progress: ProgressCallback) -> None:
    progress(Progress("initialise", 1, 1))


def train(run: Path, progress: ProgressCallback) -> None:
    progress(Progress("train", 1, 1, {"loss": float("nan")}))


def encode(run: Path, progress: ProgressCallback) -> None:
    capture = Path(json.loads((run / "run.json").read_text())["capture"])
    shutil.copytree(capture / "scene", run / "scene")
    progress(Progress("encode", 1, 1))
