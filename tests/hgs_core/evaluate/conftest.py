"""A finished run with the true scene: nothing had to be trained."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from torch import Tensor

from hgs_core.codec import encode_scene
from hgs_core.runs.creation import create_run
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from hgs_core.scene import HybridScene, Segment
from tests.synthetic import synthetic_scene, write_capture

FRAMES = 3
SIZE = (48, 64)  # height, width


@pytest.fixture(scope="session")
def capture_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("evaluate") / "capture"
    write_capture(path, frames=FRAMES, width=SIZE[1], height=SIZE[0])
    return path


@pytest.fixture
def finished(capture_folder: Path, tmp_path: Path) -> Path:
    """A run that held out the cameras 2 and 4 of 0 to 4."""
    return finished_run(tmp_path / "run", capture_folder)


def finished_run(run: Path, capture_folder: Path) -> Path:
    """Write a run of the true scene that held out the cameras 2 and 4 of 0 to 4."""
    create_run(run, capture_folder, RunConfig.for_preset("preview", capture={"hold_out": ["2", "4"]}))
    folder = RunFolder(run)
    capture = folder.read_spec().open_capture()
    static, dynamic = (splats.map(Tensor.numpy) for splats in synthetic_scene())
    scene = HybridScene(static, (Segment(float(capture.times[0]), float(capture.times[-1]), dynamic),))
    folder.train_summary.write_text(json.dumps({"seconds": 1.5}))
    encode_scene(scene, folder.scene, cameras=capture.cameras, times=capture.times, title="synthetic")
    return run


@pytest.fixture
def masks_folder(tmp_path: Path) -> Path:
    """Masks of camera 2: the left columns move, one more with every frame; none does in frame 0."""
    for frame in range(FRAMES):
        mask = np.zeros(SIZE, np.uint8)
        mask[:, :frame] = 7
        save(mask, tmp_path / "masks" / "2" / f"{frame:04d}.png")
    return tmp_path / "masks"


def save(pixels: np.ndarray, path: Path) -> None:  # type: ignore[type-arg]
    """Write a PNG file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(pixels).save(path)
