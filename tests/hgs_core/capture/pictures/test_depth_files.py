"""Given depth maps: their cameras, frames, sizes and lenses, and faults of a folder."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.capture.lenses.lens import Polynomial
from hgs_core.capture.lenses.straighten import StraightView
from hgs_core.capture.open import open_capture
from hgs_core.capture.pictures.depth_files import DepthFiles, find_depth
from hgs_core.scene.camera import Camera


def folder_of(root: Path, maps: dict[str, np.ndarray], **fields: Any) -> Path:
    for name, values in maps.items():
        path = root / f"{name}.png"
        path.parent.mkdir(parents=True, exist_ok=True)
        Image.fromarray(values).save(path)
    root.mkdir(exist_ok=True)
    (root / "depth.json").write_text(json.dumps({"scale": 0.001} | fields))
    return root


def level(value: int, size: tuple[int, int] = (64, 48)) -> np.ndarray:
    return np.full((size[1], size[0]), value, np.uint16)


def given(capture: Path, depth: Path | None, downscale: int = 1) -> tuple[DepthFiles, Camera]:
    opened = open_capture(capture, depth=depth, downscale=downscale)
    assert opened.depth is not None
    return opened.depth, opened.cameras[1]


def test_a_map_of_a_camera_and_maps_of_frames_are_found(n3dv: Path, tmp_path: Path) -> None:
    depth = folder_of(tmp_path / "depth", {"cam00": level(900), "cam01/00002": level(2000), "cam01/4": level(4000)})
    found, camera = given(n3dv, depth)
    assert (found.cameras, found.frames(0), found.frames(1)) == ([0, 1], [], [2, 4])
    whole, moment = found.still_depth(0, camera), found.depth(1, 4, camera)
    assert whole is not None
    assert moment is not None
    assert (whole[0, 0], moment[47, 63]) == (np.float32(0.9), np.float32(4.0))
    assert found.still_depth(1, camera) is None
    assert found.depth(1, 3, camera) is None


def test_a_folder_in_the_capture_is_found_and_a_note_says_so(n3dv: Path) -> None:
    folder_of(n3dv / "depth", {"cam01": level(1000)})
    assert any("depth of cam01 is given" in note for note in open_capture(n3dv).notes)


def test_a_changed_map_or_scale_changes_the_fingerprint(n3dv: Path) -> None:
    marks = [open_capture(n3dv).fingerprint()]
    for value, scale in (
        (level(1000), 0.001),
        (level(1000), 0.002),
        (np.arange(3072, dtype=np.uint16).reshape(48, 64), 0.002),
    ):
        folder_of(n3dv / "depth", {"cam01": value}, scale=scale)
        marks.append(open_capture(n3dv).fingerprint())
    assert len(set(marks)) == 4


def test_larger_maps_give_the_value_nearest_to_each_pixel(n3dv: Path, tmp_path: Path) -> None:
    """A mean of two surfaces would lie on neither."""
    values = level(1000, (128, 96))
    values[:, 65:] = 3000
    found, camera = given(n3dv, folder_of(tmp_path / "depth", {"cam01": values}), downscale=2)
    depths = found.still_depth(1, camera)
    assert depths is not None
    assert depths.shape == (24, 32)
    assert np.unique(depths).tolist() == [1.0, 3.0]
    assert (depths == 3.0).sum() == 24 * 16


def test_distances_along_rays_become_depths_along_the_axis(n3dv: Path, tmp_path: Path) -> None:
    found, camera = given(n3dv, folder_of(tmp_path / "depth", {"cam01": level(2000)}, measured="ray"))
    depths = found.still_depth(1, camera)
    assert depths is not None
    row, column = np.mgrid[0:48, 0:64] + 0.5
    rays = camera.rays(np.stack([column.ravel(), row.ravel()], 1))
    np.testing.assert_allclose(depths.ravel() * np.linalg.norm(rays, axis=1), 2.0, rtol=1e-6)


def test_a_map_of_a_bent_picture_is_straightened(tmp_path: Path) -> None:
    bent = Camera("a", 64, 48, 50.0, 50.0, 32.0, 24.0, np.eye(4))
    view = StraightView.of(bent, Polynomial(radial=(-0.2,)))
    values = np.tile(np.arange(1, 65, dtype=np.uint16) * 100, (48, 1))
    folder = folder_of(tmp_path / "depth", {"a": values})
    depths = find_depth(folder, [view], ["a"], [None], [[0]], None).still_depth(0, view.camera)
    assert depths is not None
    across = (np.arange(view.camera.width) + 0.5 - view.camera.cx) / view.camera.fx
    middle = round(view.camera.cy)
    down = (middle + 0.5 - view.camera.cy) / view.camera.fy
    u, _ = view.lens.apply(across, np.full_like(across, down))
    np.testing.assert_allclose(depths[middle], (np.floor(u * bent.fx + bent.cx) + 1) * 0.1, rtol=1e-6)


@pytest.mark.parametrize(
    ("maps", "problem"),
    [
        ({"cam07": level(1)}, r"depth: holds no depth map of this capture; call maps like the cameras cam00, cam01"),
        ({"cam01": level(1, (64, 40))}, r"cam01\.png: the depth map is 64x40.*another shape; make it 64x48"),
        ({"cam01/0001": level(1), "cam01/0002": level(1, (9, 9))}, r"0002\.png: the depth map is 9x9"),
        ({"cam01/0099": level(1)}, r"cam01: its 1 depth maps are of none of the frames in use"),
    ],
)
def test_maps_of_another_capture_are_refused(n3dv: Path, tmp_path: Path, maps: dict[str, Any], problem: str) -> None:
    with pytest.raises(InputError, match=problem):
        open_capture(n3dv, depth=folder_of(tmp_path / "depth", maps))


@pytest.mark.parametrize(
    ("values", "problem"),
    [
        (np.ones((48, 64), np.uint8), r"has 8 bits per pixel, too coarse for depths; write one channel of 16 bits"),
        (np.ones((48, 64, 3), np.uint8), r"has colours"),
    ],
)
def test_values_that_are_no_depths_are_refused(n3dv: Path, tmp_path: Path, values: np.ndarray, problem: str) -> None:
    found, camera = given(n3dv, folder_of(tmp_path / "depth", {"cam01": values}))
    with pytest.raises(InputError, match=problem):
        found.still_depth(1, camera)


def test_a_missing_folder_is_refused(n3dv: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nowhere: the folder of depth maps does not exist"):
        open_capture(n3dv, depth=tmp_path / "nowhere")
