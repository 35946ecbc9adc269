from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.capture_config import CaptureConfig
from hgs_core.capture.open import open_capture
from tests.synthetic import write_capture


def test_all_cameras_are_trained_on_but_those_held_out(tmp_path: Path) -> None:
    write_capture(tmp_path, frames=1)
    capture = open_capture(tmp_path)
    assert CaptureConfig(hold_out=("1", "3")).training_cameras(capture) == (0, 2, 4)
    with pytest.raises(InputError, match="there is no camera '7'"):
        CaptureConfig(hold_out=("7",)).training_cameras(capture)


def test_the_memory_for_frames_is_the_size_of_the_cache(tmp_path: Path) -> None:
    write_capture(tmp_path, frames=1)
    capture = open_capture(tmp_path, cache_bytes=CaptureConfig(frame_memory_mib=3).cache_bytes)
    assert capture.cache_bytes == 3 * 2**20


def test_factors_of_single_cameras_are_read_by_name() -> None:
    assert CaptureConfig(downscale_cameras=("cam 04=4", "a=b=2")).reductions == {"cam 04": 4, "a=b": 2}


@pytest.mark.parametrize("given", [("cam04",), ("cam04=0",), ("cam04=1000",), ("=2",), ("a=2", "a=3"), ("a=x",)])
def test_factors_that_are_none_are_refused(given: tuple[str, ...]) -> None:
    with pytest.raises(InputError, match="downscale_cameras"):
        CaptureConfig(downscale_cameras=given)
