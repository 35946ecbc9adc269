"""Our viewer beside others: the camera common to all, and early refusals."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.viewers.viewers_bench import bench_viewers, turned_camera
from hgs_core.base.errors import InputError
from hgs_core.base.progress import silent

CAMERA = {"eye": [0, 1, 4], "target": [0, 1, 0], "up": [0, 1, 0], "fovY": 90.0, "near": 0.1}


def test_camera_looks_at_the_target_with_the_horizon_level() -> None:
    camera = turned_camera(CAMERA, 0, (64, 48))
    eye = camera.world_to_camera @ [0, 1, 4, 1]
    target = camera.world_to_camera @ [0, 1, 0, 1]
    above = camera.world_to_camera @ [0, 2, 0, 1]
    np.testing.assert_allclose([eye[:3], target[:3], above[:3]], [[0, 0, 0], [0, 0, 4], [0, -1, 4]], atol=1e-12)
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == pytest.approx((24, 24, 32, 24))


def test_camera_turns_about_the_up_axis_to_the_right() -> None:
    turned = turned_camera(CAMERA, 90, (64, 48)).world_to_camera
    np.testing.assert_allclose(-turned[:3, :3].T @ turned[:3, 3], [4, 1, 0], atol=1e-12)


def test_unknown_viewer_is_refused_with_those_there_are(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"--viewers: nobody is unknown.*playcanvas"):
        bench_viewers(tmp_path, silent, viewers=("hgs", "nobody"))
