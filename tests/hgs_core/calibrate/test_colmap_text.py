"""COLMAP's own reader is the reference."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image  # noqa: F401 - before pycolmap

from hgs_core.calibrate.colmap_text import write_colmap_text
from hgs_core.calibrate.structure import Solution, SolvedCamera


def test_colmap_reads_what_was_written(tmp_path: Path) -> None:
    import pycolmap

    numbers = np.random.default_rng(2)
    cameras = []
    for number in range(6):
        pose = np.eye(4)
        turn = np.linalg.qr(numbers.normal(size=(3, 3)))[0]
        pose[:3, :3], pose[:3, 3] = turn * np.sign(np.linalg.det(turn)), numbers.normal(size=3)
        lens = (600.25, 320.0, 240.0, -0.0125) if number else (512.0, 320.0, 240.0, 0.0)
        cameras.append(SolvedCamera(f"cam{number}", 640, 480, "SIMPLE_RADIAL", lens, pose, 9))
    write_colmap_text(tmp_path / "sparse" / "0", Solution(tuple(cameras), numbers.normal(size=(4, 3)), 0.3))
    model = pycolmap.Reconstruction(str(tmp_path / "sparse" / "0"))
    read = {str(image.name): image for image in model.images.values()}
    assert sorted(read) == [camera.name for camera in sorted(cameras, key=lambda one: one.name)]
    for camera in cameras:
        image = read[camera.name]
        np.testing.assert_allclose(image.cam_from_world().matrix(), camera.world_to_camera[:3], atol=1e-9)
        np.testing.assert_allclose(model.cameras[image.camera_id].params, camera.parameters, rtol=1e-9)
    assert len(model.cameras) == 2
    assert len(model.points3D) == 4
