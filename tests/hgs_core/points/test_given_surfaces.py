"""Depth maps and a mesh of a capture, as depths of the still scene."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hgs_core.capture.capture import Capture
from hgs_core.capture.open import open_capture
from hgs_core.decompose.mask_segment import MaskSegment, packed_mask
from hgs_core.decompose.masks import MotionMasks
from hgs_core.points.given_surfaces import GivenSurfaces
from tests.synthetic import write_capture

WIDTH, HEIGHT, FRAMES = 32, 24, 6
MOVER = np.zeros((HEIGHT, WIDTH), bool)
MOVER[4:9, 10:15] = True


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_capture(tmp_path / "capture", 2, FRAMES, WIDTH, HEIGHT)
    depth = tmp_path / "capture" / "depth"
    depth.mkdir()
    (depth / "depth.json").write_text(json.dumps({"scale": 0.001}))
    return tmp_path / "capture"


def write_map(path: Path, millimetres: np.ndarray) -> None:
    path.parent.mkdir(exist_ok=True)
    Image.fromarray(millimetres.astype(np.uint16)).save(path)


def surfaces(folder: Path) -> tuple[GivenSurfaces, Capture]:
    capture = open_capture(folder)
    rows = {camera: [packed_mask(MOVER if frame < 5 else ~MOVER) for frame in range(FRAMES)] for camera in (0, 1)}
    masks = MotionMasks(capture, [0, 1], lambda frame: MaskSegment(range(FRAMES), rows))
    return GivenSurfaces(capture, masks), capture


def test_the_median_over_time_leaves_movers_out(folder: Path) -> None:
    for frame, depth in enumerate((3000, 3010, 3020, 3030)):
        values = np.full((HEIGHT, WIDTH), depth)
        values[MOVER] = 1500  # the mover, in front of the wall
        values[20:] = 0 if frame else 4000
        write_map(folder / "depth" / "1" / f"{frame}.png", values)
    found, capture = surfaces(folder)
    depths = found.still(1, capture.cameras[1])
    assert depths is not None
    assert not depths[MOVER].any()
    assert np.unique(depths[:4]).tolist() == [np.float32(3.01)]
    assert np.unique(depths[20:]).tolist() == [4.0]
    assert found.still(0, capture.cameras[0]) is None


def test_a_frame_shows_its_movers(folder: Path) -> None:
    write_map(folder / "depth" / "1" / "2.png", np.where(MOVER, 1500, 3000))
    found, _ = surfaces(folder)
    depths = found.at(1, 2)
    assert depths is not None
    assert np.unique(depths[MOVER]).tolist() == [1.5]
    assert found.at(1, 3) is None


@pytest.mark.parametrize("mirrored", [False, True])
def test_the_mesh_fills_what_the_maps_leave_open(folder: Path, mirrored: bool) -> None:
    """Of a world that was mirrored with its cameras, the mesh is mirrored, too."""
    values = np.full((HEIGHT, WIDTH), 2000)
    values[:, 16:] = 0
    write_map(folder / "depth" / "0.png", values)
    camera = open_capture(folder).cameras[0]
    corners = camera.position + camera.rays(np.array([[-99, -99], [131, -99], [131, 131], [-99, 131.0]])) * 5
    lines = [f"v {-x if mirrored else x} {y} {z}\n" for x, y, z in corners]
    (folder / "mesh.obj").write_text("".join([*lines, "f 1 2 3 4\n"]))
    found, capture = surfaces(folder)
    capture.mirrored = mirrored
    depths = found.still(0, capture.cameras[0])
    assert depths is not None
    np.testing.assert_allclose(depths[:, :16], 2.0)
    np.testing.assert_allclose(depths[:, 16:], 5.0, rtol=1e-5)
