"""From videos to sync.json, by sound and by how much changes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.progress import silent
from hgs_core.capture.time.sync import read_sync
from hgs_core.check.starts import Starts, starts_by_energy, starts_by_sound
from tests.hgs_core.capture.sounding import write_sounding_video
from tests.hgs_core.check.test_starts_by_sound import heard, scene


@pytest.fixture(scope="module")
def videos(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder, sound = tmp_path_factory.mktemp("sounding"), 0.2 * scene(5)
    tracks = {"a": heard(sound, 0.5), "b": heard(sound, 0.0), "c": heard(sound, 0.5167), "mute": None}
    return [write_sounding_video(folder / f"{name}.mkv", 4, track) for name, track in tracks.items()]


def test_sound_tells_when_cameras_began_and_how_sure_that_is(videos: list[Path], tmp_path: Path) -> None:
    starts = starts_by_sound(tmp_path, ["a", "b", "c"], videos[:3], silent)
    starts.write(tmp_path / "sync.json")
    assert read_sync(tmp_path).starts == pytest.approx({"a": 0.5, "b": 0.0, "c": 0.5167}, abs=2e-4)
    content = json.loads((tmp_path / "sync.json").read_text())
    assert content["by"] == "sound"
    assert set(content["confidence"]) == {"a", "b", "c"}
    assert "confidence" in starts.lines()[0]


def test_a_video_without_sound_is_named_with_the_cure(videos: list[Path], tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no sound track in the video of mute") as refused:
        starts_by_sound(tmp_path, ["a", "b", "c", "mute"], videos, silent)
    assert "motion" in str(refused.value)


def flashes(shifts: list[int], frames: int = 60) -> tuple[list[str], object, int]:
    """Pictures that brighten by random steps, begun some frames apart."""
    levels = np.random.default_rng(0).integers(0, 200, frames + 20)

    def picture(camera: int, frame: int) -> np.ndarray:
        return np.full((12, 16, 3), levels[frame + shifts[camera]], np.uint8)

    return [f"cam{i}" for i in range(len(shifts))], picture, frames


def test_what_changes_tells_whole_frames_without_poses() -> None:
    names, picture, frames = flashes([0, 3, 7, 0])
    starts = starts_by_energy(names, picture, frames, silent)  # type: ignore[arg-type]
    assert starts is not None
    assert starts.apart == pytest.approx(7, abs=0.3)
    assert starts.values["cam1"] - starts.values["cam0"] == pytest.approx(3, abs=0.3)


def test_of_a_short_or_a_still_video_nothing_is_told() -> None:
    names, picture, _ = flashes([0, 3, 7])
    assert starts_by_energy(names, picture, 29, silent) is None  # type: ignore[arg-type]
    assert starts_by_energy(names, lambda camera, frame: np.zeros((12, 16, 3), np.uint8), 60, silent) is None


def test_offsets_by_motion_are_frames(tmp_path: Path) -> None:
    Starts("motion", "frames", {"a": 0.0, "b": 2.5}).write(tmp_path / "sync.json")
    sync = read_sync(tmp_path)
    assert (sync.starts, sync.in_frames) == ({"a": 0.0, "b": 2.5}, True)
