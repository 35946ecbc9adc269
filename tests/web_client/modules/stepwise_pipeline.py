"""A pipeline that trains as far as its capture says, so that a page can be looked at on the way.

The capture is a folder of the nerfstudio layout with a finished scene in scene/, and a file `until`: the training goes
on while it has done less than the number in there. It fails at the end if there is a file `fail`.
"""

from __future__ import annotations

import io
import json
import shutil
import sys
import time
from pathlib import Path

from PIL import Image

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.capture.held_out import AUTO
from hgs_core.runs.given_files import GivenFiles
from hgs_core.runs.run_config import RunConfig

TOTAL = 400


def create_run(run: Path, capture: Path, config: RunConfig, given: GivenFiles) -> RunConfig:
    cameras = len(json.loads((capture / "transforms.json").read_text())["frames"])
    if config.capture.hold_out == AUTO:
        config = config.changed({"capture.hold_out": ()})
    left = cameras - len(config.capture.hold_out)
    if left < 2:
        raise InputError.of_field(
            "config.capture.hold_out", f"leaves {left} of {cameras} cameras to train on", "keep at least 2"
        )
    if not (capture / "scene").is_dir():
        raise InputError(capture / "left.png", "the picture is unreadable", "restore the file")
    run.mkdir(parents=True, exist_ok=True)
    (run / "run.json").write_text(json.dumps({"capture": str(capture)}))
    return config


def initialise(run: Path, progress: ProgressCallback) -> None:
    progress(Progress("masks", 3, 3))
    progress(Progress("points", 9, 9))


def train(run: Path, progress: ProgressCallback) -> None:
    capture = _capture(run)
    print("two of 100 frames look alike", file=sys.stderr)
    checkpoint = run / "done"
    done = int(checkpoint.read_text()) if checkpoint.exists() else 0
    while done < TOTAL:
        figures = {"psnr": 30.0 - 12.0 / (1 + done / 60), "loss": 0.3 / (1 + done / 60), "static": 1000.0 + done}
        progress(Progress("train", done, TOTAL, figures))
        if done < int((capture / "until").read_text()):
            done += 4
            checkpoint.write_text(str(done))
            file = io.BytesIO()
            Image.new("RGB", (160, 90), (done * 255 // TOTAL, 90, 120)).save(file, "JPEG")
            write_bytes(run / "preview.jpg", file.getvalue())
        time.sleep(0.02)
        if done == TOTAL // 2 and (capture / "fail").exists():
            raise RuntimeError("the loss is not a number")
    progress(Progress("train", TOTAL, TOTAL, {"psnr": 28.5, "loss": 0.04, "static": 1400.0}))


def encode(run: Path, progress: ProgressCallback) -> None:
    shutil.copytree(_capture(run) / "scene", run / "scene", dirs_exist_ok=True)
    progress(Progress("encode", 1, 1))


def _capture(run: Path) -> Path:
    return Path(json.loads((run / "run.json").read_text())["capture"])
