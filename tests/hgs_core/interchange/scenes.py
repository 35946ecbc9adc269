"""Scenes to write to files, and counts of losses."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import torch

from hgs_core.interchange import Change, export_scene
from hgs_core.interchange.antialiasing_note import note_of
from hgs_core.interchange.ply.ply_table import write_ply
from hgs_core.render.scene_picture import scene_picture
from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats
from hgs_core.scene.camera import Camera
from hgs_core.scene.rotations import matrices
from tests.synthetic import ring_of_cameras, synthetic_scene

CAMERA = Camera("cam00", 640, 480, 500.0, 510.0, 320.0, 240.0, np.eye(4))
Write = Callable[[str, bytes], Path]
Counted = dict[tuple[str, str], int | None]


def statics(count: int = 50, seed: int = 0) -> StaticSplats[np.ndarray]:
    rng = np.random.default_rng(seed)
    quats = rng.normal(size=(count, 4))
    return StaticSplats(
        rng.normal(0, 2, (count, 3)).astype(np.float32),
        rng.uniform(-6, -1, (count, 3)).astype(np.float32),
        (quats / np.linalg.norm(quats, axis=1, keepdims=True)).astype(np.float32),
        rng.normal(1, 2, count).astype(np.float32),
        rng.uniform(0.05, 0.95, (count, 3)).astype(np.float32),
    )


def dynamics(count: int = 30, seed: int = 1) -> DynamicSplats[np.ndarray]:
    rng = np.random.default_rng(seed)
    still = statics(count, seed)
    motion = rng.normal(0, 0.5, (count, 4, 3)).astype(np.float32)
    return DynamicSplats(
        motion,
        np.stack([still.quats, rng.normal(size=(count, 4)).astype(np.float32)], axis=1),
        still.log_scales,
        np.abs(still.opacity_logits),
        rng.uniform(0, 1, count).astype(np.float32),
        rng.normal(2, 1, count).astype(np.float32),
        still.rgb,
    )


def plain(count: int = 20) -> StaticSplats[np.ndarray]:
    """Splats that every format holds to the bit."""
    k = np.arange(count)
    return StaticSplats(
        (np.stack([k, -k, k], axis=1) / 64).astype(np.float32),
        np.full((count, 3), -2.0, np.float32),
        np.tile(np.float32([1, 0, 0, 0]), (count, 1)),
        np.full(count, np.log(51 / 204), np.float32),  # 51 / 255
        np.full((count, 3), 0.5, np.float32),
    )


def plain_but(**changed: dict[int, float]) -> HybridScene[np.ndarray]:
    """The plain splats with some numbers (by row, in the first column) replaced."""
    arrays = {name: array.copy() for name, array in plain().items()}
    for name, values in changed.items():
        for row, value in values.items():
            arrays[name].reshape(20, -1)[row, 0] = value
    return HybridScene(StaticSplats(**arrays), (Segment(0.0, 0.0, DynamicSplats.empty()),))


def counted(changes: Iterable[Change]) -> Counted:
    """Return the counts by action and attribute; no two changes may share both."""
    found = [((str(change.action), change.what), change.count) for change in changes]
    assert len(dict(found)) == len(found)
    return dict(found)


def export(scene: HybridScene[np.ndarray], path: Path, **more: object) -> tuple[Change, ...]:
    """Write a scene that one camera has seen."""
    return export_scene(scene, path, cameras=[CAMERA], **more)  # type: ignore[arg-type]


def gaussian_ply_of(splats: StaticSplats[np.ndarray], **more: np.ndarray) -> bytes:
    """A 3DGS file with the splats' own logits, infinite ones too, and further properties; not drawn antialiased."""
    names = ["x", "y", "z", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3", "opacity"]
    with np.errstate(over="ignore"):
        dc = (splats.rgb - 0.5) / 0.28209479
    table = np.concatenate([splats.means, splats.log_scales, splats.quats, splats.opacity_logits[:, None], dc], axis=1)
    columns = dict(zip([*names, "f_dc_0", "f_dc_1", "f_dc_2"], table.T, strict=True)) | more
    return write_ply(columns, [note_of(False)])


def axes_of(quats: np.ndarray) -> np.ndarray:
    """The rotation matrices of quaternions of any length."""
    return matrices(quats / np.linalg.norm(quats, axis=1, keepdims=True))


def figure() -> HybridScene[np.ndarray]:
    """The synthetic figure, which moves for 2 s."""
    static, dynamic = (splats.map(lambda array: array.numpy()) for splats in synthetic_scene())
    return HybridScene(static, (Segment(0.0, 2.0, dynamic),), antialiased=True)


def figure_picture(scene: HybridScene[np.ndarray], seconds: float) -> torch.Tensor:
    """A camera's picture of the figure, which must not be black."""
    camera = ring_of_cameras(4, 160, 120)[0]
    alike = dataclasses.replace(scene, antialiased=True).map(torch.from_numpy)
    picture = scene_picture(alike, camera, seconds).rgb.clamp(0, 1)
    assert float(picture.mean()) > 0.1
    return picture
