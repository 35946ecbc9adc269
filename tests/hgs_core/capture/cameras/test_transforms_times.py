"""The meaning of times in transforms.json: shares, numbers of frames, or a unit."""

from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.open import open_capture
from tests.hgs_core.capture import layouts
from tests.hgs_core.capture.layouts import FRAMES

_UNITS = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}


@pytest.mark.parametrize("rate", [24.0, 30.0, 60.0, 120.0])
@pytest.mark.parametrize("unit", _UNITS)
def test_times_of_transforms_json_are_read_in_their_unit(tmp_path: Path, rate: float, unit: str) -> None:
    """Of pictures nothing states the rate: steps of usual rates tell the unit."""
    pattern = "images/{camera}/{frame}.png"
    layouts.folders(pattern)(tmp_path)

    def time(frame: int) -> float:
        return 100 * _UNITS[unit] + (frame / rate * _UNITS[unit] if unit == "s" else round(frame / rate * _UNITS[unit]))

    layouts.transforms(layouts.frames_of_pictures(pattern, time))(tmp_path)
    assert open_capture(tmp_path).seconds == pytest.approx((FRAMES - 1) / rate, rel=0.02, abs=0.0015)


@pytest.mark.parametrize("step", [1, 2, 5])
def test_whole_times_of_transforms_json_in_small_steps_are_frames(tmp_path: Path, step: int) -> None:
    pattern = "images/{camera}/{frame}.png"
    layouts.folders(pattern)(tmp_path)
    layouts.transforms(layouts.frames_of_pictures(pattern, lambda frame: 10 + step * frame))(tmp_path)
    assert open_capture(tmp_path).seconds == pytest.approx(step * (FRAMES - 1) / 30)


def test_times_of_no_rate_in_transforms_json_are_refused_and_the_cure_cures(tmp_path: Path) -> None:
    pattern = "images/{camera}/{frame}.png"
    layouts.folders(pattern)(tmp_path)
    layouts.transforms(layouts.frames_of_pictures(pattern, lambda frame: 700.5 * frame))(tmp_path)
    with pytest.raises(
        InputError, match=r'times of frames are 700\.5 apart, which is no usual rate .*remove "time" from all'
    ):
        open_capture(tmp_path)
    layouts.transforms(layouts.frames_of_pictures(pattern))(tmp_path)
    assert len(open_capture(tmp_path).times) == FRAMES


@pytest.mark.parametrize("step", [10, 40])
def test_large_steps_are_frames_where_the_pictures_numbers_step_alike(tmp_path: Path, step: int) -> None:
    """0, 40, 80 are milliseconds of 25 per second, but of pictures 0000, 0040, 0080 every fortieth frame."""
    layouts.folders("images/{camera}/{frame}.png")(tmp_path)
    for folder in (tmp_path / "images").iterdir():
        for frame in range(FRAMES):
            (folder / f"{frame}.png").rename(folder / f"{step * frame:04d}.jpg")
    frames = layouts.frames_of_pictures("images/{camera}/{frame}", lambda frame: step * frame)
    for number, frame in enumerate(frames):
        frame["file_path"] = f"{Path(frame['file_path']).parent}/{step * (number % FRAMES):04d}.jpg"
    layouts.transforms(frames)(tmp_path)
    assert open_capture(tmp_path).seconds == pytest.approx(step * (FRAMES - 1) / 30)
