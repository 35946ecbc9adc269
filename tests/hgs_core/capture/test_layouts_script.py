"""`scripts/make_layouts.py`: one capture in every layout."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.open import open_capture
from scripts.make_layouts import LAYOUTS, write_layouts
from tests.hgs_core.capture.conftest import encode_video


def test_every_layout_has_the_same_cameras_and_pictures(n3dv: Path, tmp_path: Path) -> None:
    written = write_layouts(n3dv, tmp_path / "out", cameras=2, frames=4)
    assert {folder.name for folder in written} > set(LAYOUTS)
    base = open_capture(tmp_path / "out" / "n3dv")
    for name in LAYOUTS:
        capture = open_capture(tmp_path / "out" / name)
        for index, (camera, true) in enumerate(zip(capture.cameras, base.cameras, strict=True)):
            np.testing.assert_allclose(camera.world_to_camera, true.world_to_camera, atol=1e-9, err_msg=name)
            assert (camera.fx, camera.fy, camera.cx, camera.cy) == pytest.approx((true.fx, true.fy, true.cx, true.cy))
            np.testing.assert_array_equal(capture.frame(index, 3), base.frame(index, 3))


def test_a_fisheye_s_straight_pictures_show_what_the_pinhole_saw(n3dv: Path, tmp_path: Path) -> None:
    write_layouts(n3dv, tmp_path / "out", cameras=2, frames=4)
    bent, straight = (open_capture(tmp_path / "out" / name) for name in ("fisheye", "fisheye_as_pinhole"))
    for camera, true in zip(bent.cameras, straight.cameras, strict=True):
        assert abs(camera.width - true.width) <= 1
        assert camera.fx == pytest.approx(true.fx)
    assert abs(int(bent.frame(1, 2).mean()) - int(straight.frame(1, 2).mean())) <= 1


def test_late_cameras_have_their_own_times_where_sync_json_says_so(n3dv: Path, tmp_path: Path) -> None:
    for video in n3dv.glob("*.mp4"):
        encode_video(video, [10 * frame for frame in range(16)])
    write_layouts(n3dv, tmp_path / "out", cameras=2, frames=4)
    moments = [open_capture(tmp_path / "out" / name).moment(1, 0) for name in ("late", "late_with_sync")]
    assert moments == [0.0, pytest.approx(0.5 * 4 / 30)]


def test_a_folder_that_is_not_empty_is_left_alone(n3dv: Path) -> None:
    with pytest.raises(InputError, match="exists and is not empty"):
        write_layouts(n3dv, n3dv, cameras=2, frames=4)
