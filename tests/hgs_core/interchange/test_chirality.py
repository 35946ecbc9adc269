"""No format mirrors the scene: neither a file, read by hand in the format's own axes, nor its import."""

from __future__ import annotations

import gzip
import json
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch

from hgs_core.interchange import IMPORTED, export_scene, import_scene
from hgs_core.render import rasterize
from hgs_core.scene import HybridScene
from hgs_core.scene.camera import Camera
from tests.chirality import Doubles, assert_not_mirrored, letters, views

WIDTH, HEIGHT = 192, 144


def ply_positions(data: bytes) -> tuple[Doubles, Doubles]:
    """3DGS and STGS: the world of the capture. 3DGS has colours as harmonics of degree 0."""
    header, _, body = data.partition(b"end_header\n")
    names = [line.split()[-1].decode() for line in header.splitlines() if line.startswith(b"property float")]
    rows = np.frombuffer(body, "<f4").reshape(-1, len(names)).astype(np.float64)
    column = dict(zip(names, rows.T, strict=True))
    colours = np.stack([column[f"f_dc_{i}"] for i in range(3)], axis=1)
    if "trbf_center" not in column:
        colours = 0.5 + 0.28209479177387814 * colours
    return np.stack([column[axis] for axis in "xyz"], axis=1), colours


def splat_positions(data: bytes) -> tuple[Doubles, Doubles]:
    """.splat: records of 32 bytes, x, y, z first, colours at 24; the world of the capture."""
    rows = np.frombuffer(data, np.uint8).reshape(-1, 32)
    return rows[:, :12].copy().view("<f4").astype(np.float64), rows[:, 24:27] / 255.0


def splatv_positions(data: bytes) -> tuple[Doubles, Doubles]:
    """.splatv: records of 64 bytes after a JSON header, x, y, z first, colours at 28; opacity 0 fills up."""
    (length,) = struct.unpack_from("<I", data, 4)
    rows = np.frombuffer(data[8 + length :], np.uint8).reshape(-1, 64)
    rows = rows[rows[:, 31] > 0]
    return rows[:, :12].copy().view("<f4").astype(np.float64), rows[:, 28:31] / 255.0


def spz_positions(data: bytes) -> tuple[Doubles, Doubles]:
    """SPZ: x to the right, y up, z to the back, in fixed point of 24 bits; then opacities, then colours."""
    raw = gzip.decompress(data)
    count, bits = struct.unpack_from("<I", raw, 8)[0], raw[13]
    low, middle, high = (np.frombuffer(raw, np.uint8, 9 * count, 16)[i::3].astype(np.int64) for i in range(3))
    fixed = low + (middle << 8) + (high << 16)
    right, up, back = (np.where(fixed < 1 << 23, fixed, fixed - (1 << 24)).reshape(-1, 3) / 2**bits).T
    colours = np.frombuffer(raw, np.uint8, 3 * count, 16 + 10 * count).reshape(-1, 3)
    # A viewer of OpenGL's axes looks along -z with y up; a capture's camera along z with y down.
    return np.stack([right, -up, -back], axis=1), 0.5 + 0.28209479177387814 * (colours / 255 - 0.5) / 0.15


def glb_positions(data: bytes) -> tuple[Doubles, Doubles]:
    """GLB: x to the right, y up, z to the viewer, and colours as harmonics of degree 0, where the document says."""
    size = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20 : 20 + size])
    names = document["meshes"][0]["primitives"][0]["attributes"]
    arrays = []
    for name in ("POSITION", "KHR_gaussian_splatting:SH_DEGREE_0_COEF_0"):
        view = document["bufferViews"][document["accessors"][names[name]]["bufferView"]]
        floats = np.frombuffer(data, "<f4", view["byteLength"] // 4, 28 + size + view["byteOffset"])
        arrays.append(floats.reshape(-1, 3).astype(np.float64))
    right, up, back = arrays[0].T
    return np.stack([right, -up, -back], axis=1), 0.5 + 0.28209479177387814 * arrays[1]


def fourdgs_positions(data: bytes) -> tuple[Doubles, Doubles]:
    """.4dgs, as the library of the format's makers reads it; axes by the record that the file has of them."""
    scene = pytest.importorskip("fourdgs").read(data)
    assert (scene.provenance.frame.up_axis, scene.provenance.frame.forward_axis) == (4, 2)  # -y, +z
    rows = scene.gaussians.state_at(0.5, cutoff=scene.header.cutoff)
    return rows["centers"], scene.gaussians.colors[rows["indices"], :3]


Read = Callable[[bytes], tuple[Doubles, Doubles]]
FORMATS: dict[str, tuple[str, bool, Read]] = {
    "3DGS ply": ("a.ply", False, ply_positions),
    "STGS ply": ("a.ply", True, ply_positions),
    "splat": ("a.splat", False, splat_positions),
    "splatv": ("a.splatv", True, splatv_positions),
    "spz": ("a.spz", False, spz_positions),
    "glb": ("a.glb", False, glb_positions),
    "4dgs": ("a.4dgs", True, fourdgs_positions),
}
every_format = pytest.mark.parametrize(("name", "moving", "read"), FORMATS.values(), ids=FORMATS.keys())


def dots(positions: Doubles, colours: Doubles, camera: Camera) -> Doubles:
    """Return a camera's picture of points, each a disc, the farthest first."""
    picture = np.zeros((camera.height, camera.width, 3))
    seen = positions @ camera.world_to_camera[:3, :3].T + camera.world_to_camera[:3, 3]
    rows, columns = np.mgrid[: camera.height, : camera.width] + 0.5
    for i in np.argsort(-seen[:, 2]):
        x, y = camera.fx * seen[i, 0] / seen[i, 2] + camera.cx, camera.fy * seen[i, 1] / seen[i, 2] + camera.cy
        picture[np.hypot(columns - x, rows - y) < 0.07 * camera.fx / seen[i, 2]] = colours[i]
    return picture


def exported(path: Path, moving: bool) -> HybridScene[np.ndarray]:
    if path.suffix == ".4dgs":
        pytest.importorskip("fourdgs", reason="fourdgs is not installed (extra 4dgs)")
    scene = letters(moving=moving)
    export_scene(scene, path, cameras=views(WIDTH, HEIGHT))
    return scene


@every_format
def test_a_file_read_by_hand_is_not_mirrored(tmp_path: Path, name: str, moving: bool, read: Read) -> None:
    exported(tmp_path / name, moving)
    positions, colours = read((tmp_path / name).read_bytes())
    for camera in views(WIDTH, HEIGHT):
        assert_not_mirrored(dots(positions, colours, camera), camera)


@pytest.mark.parametrize(
    ("name", "moving"), [(name, moving) for name, moving, _ in FORMATS.values() if Path(name).suffix in IMPORTED]
)
def test_what_is_imported_is_not_mirrored(tmp_path: Path, name: str, moving: bool) -> None:
    exported(tmp_path / name, moving)
    scene = import_scene(tmp_path / name, 1.0).scene.map(torch.from_numpy)
    for camera in views(WIDTH, HEIGHT):
        dynamic = scene.segments[0].dynamic
        render = rasterize(scene.static, dynamic, camera, 0.5, backend="reference", gradients="none")
        assert_not_mirrored(render.rgb.permute(1, 2, 0).numpy(), camera)
