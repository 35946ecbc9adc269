"""A scene folder with sound, for films."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.capture.sound.sound_track import SOUND_RATE
from hgs_core.codec import encode_scene
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder, RunSpec
from hgs_core.runs.sound import replace_sound
from hgs_core.scene.splats import HybridScene, Segment
from tests.hgs_core.capture.sounding import write_sounding_video
from tests.synthetic import ring_of_cameras, synthetic_scene


def tone(seconds: float) -> np.ndarray:  # type: ignore[type-arg]
    """Return a quiet tone of 440 Hz that begins at 0.25 s and ends at 0.75 s."""
    time = np.arange(round(seconds * SOUND_RATE)) / SOUND_RATE
    heard = (time >= 0.25) & (time < 0.75)
    return np.asarray(0.3 * np.sin(2 * np.pi * 440 * time) * heard, np.float32)


@pytest.fixture(scope="session")
def sounding_scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An encoded scene of a second, 20 frames per second, with a tone."""
    home = tmp_path_factory.mktemp("film")
    folder = RunFolder(home / "run")
    static, dynamic = (splats.map(lambda array: array.numpy()) for splats in synthetic_scene())
    folder.write_spec(RunSpec(home / "capture", "", RunConfig(), without_capture=True))
    scene = HybridScene(static, (Segment(0.0, 1.0, dynamic),))
    cameras = ring_of_cameras(4, 64, 48)
    encode_scene(scene, folder.scene, cameras=cameras, times=np.arange(21) / 20, title="Figure")
    video = home / "tone.mkv"
    write_sounding_video(video, 21, tone(1.0))
    replace_sound(home / "run", str(video))
    return folder.scene
