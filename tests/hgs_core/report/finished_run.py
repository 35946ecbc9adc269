"""A finished run of the synthetic capture, without the minutes of training: its scene is the one that was filmed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from hgs_core.codec import encode_scene
from hgs_core.runs.creation import create_run
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from hgs_core.scene import HybridScene, Segment
from tests.synthetic import synthetic_scene, write_capture

__all__ = ["HISTORY", "write_finished_run"]

FRAMES = 8
HISTORY: dict[str, list[float]] = {
    "iteration": [10.0, 20.0, 30.0, 40.0],
    "seconds": [2.0, 3.0, 7.0, 12.0],
    "loss": [0.4, 0.2, 0.15, 0.1],
    "psnr": [14.0, 18.0, 20.0, 21.0],
    "static": [100.0, 120.0, 150.0, 150.0],
    "dynamic": [1.0, 2.0, 3.0, 3.0],
}


def write_finished_run(
    folder: Path, name: str = "run", hold_out: tuple[str, ...] = ("2",), *, statics: int = 150, **summary: Any
) -> Path:
    """Write folder/capture, if it is not there, and a run of it that has kept some of the static splats.

    `summary` is added to train.json.
    """
    capture = folder / "capture"
    if not capture.exists():
        write_capture(capture, frames=FRAMES)
    run = RunFolder(folder / name)
    config = RunConfig.for_preset("preview", capture={"hold_out": hold_out}, train={"iterations": 40})
    create_run(run.path, capture, config)
    opened = run.read_spec().open_capture()
    static, dynamic = (splats.map(lambda array: array.numpy()) for splats in synthetic_scene())
    segment = Segment(float(opened.times[0]), float(opened.times[-1]), dynamic)
    run.train_summary.write_text(json.dumps({"seconds": 12.0, "iterations": 40, **summary}))
    scene: HybridScene[np.ndarray] = HybridScene(static.take(slice(statics)), (segment,))
    encode_scene(scene, run.scene, cameras=opened.cameras, times=opened.times, title=opened.name)
    return run.path
