"""A tiny capture with known truth: a still scene with one moving splat, written in the PanopticSports layout."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import torch
from PIL import Image
from torch import Tensor

from hgs_core.render.reference import rasterize_reference
from hgs_core.render.types import View
from hgs_core.scene import DynamicSplats, StaticSplats
from hgs_core.scene.camera import Camera, looking_at
from hgs_core.train.splat_sets import joined

__all__ = ["EVENT_PLACE", "event_splats", "ring_of_cameras", "synthetic_scene", "write_capture"]

EVENT_PLACE = np.array([0.0, 0.1, -1.2])
"""Centre of the ball of `event_splats`."""


def ring_of_cameras(count: int, width: int, height: int) -> list[Camera]:
    """Cameras on an arc of 90 degrees around the origin, three units away, looking at it."""
    cameras = []
    for i in range(count):
        angle = np.deg2rad(-45 + 90 * i / max(1, count - 1))
        forward = np.array([np.sin(angle), 0.1, np.cos(angle)])
        pose = looking_at(-3 * forward / np.linalg.norm(forward), np.zeros(3))
        cameras.append(Camera(str(i), width, height, 1.2 * width, 1.2 * width, width / 2, height / 2, pose))
    return cameras


def synthetic_scene(seed: int = 0) -> tuple[StaticSplats[Tensor], DynamicSplats[Tensor]]:
    """A cloud of 150 coloured still splats and three that fly across it."""
    r = np.random.default_rng(seed)
    count, moving = 150, 3
    static = StaticSplats(
        r.uniform(-1, 1, (count, 3)),
        np.log(r.uniform(0.08, 0.25, (count, 3))),
        r.normal(size=(count, 4)),
        np.full(count, 2.0),
        r.uniform(0.1, 0.9, (count, 3)),
    )
    motion = np.zeros((moving, 4, 3))
    motion[:, 0] = r.uniform(-0.3, 0.3, (moving, 3))
    motion[:, 1] = r.uniform(-1.0, 1.0, (moving, 3))
    rotation = np.zeros((moving, 2, 4))
    rotation[:, 0, 0] = 1
    dynamic = DynamicSplats(
        motion,
        rotation,
        np.full((moving, 3), np.log(0.2)),
        np.full(moving, 3.0),
        np.full(moving, 0.5),
        np.full(moving, np.log(0.1)),
        r.uniform(0, 1, (moving, 3)),
    )
    to_torch = lambda array: torch.tensor(array, dtype=torch.float32)  # noqa: E731
    return static.map(to_torch), dynamic.map(to_torch)


def event_splats() -> StaticSplats[Tensor]:
    """A ball in front of the cloud, of 60 splats in bright colours: something that can appear and vanish."""
    r = np.random.default_rng(1)
    count = 60
    shell = r.normal(size=(count, 3))
    shell *= 0.25 / np.linalg.norm(shell, axis=1, keepdims=True)
    ball = StaticSplats(
        EVENT_PLACE + shell,
        np.full((count, 3), np.log(0.06)),
        np.tile([1.0, 0, 0, 0], (count, 1)),
        np.full(count, 4.0),
        np.eye(3)[r.integers(0, 3, count)],
    )
    return ball.map(lambda array: torch.tensor(array, dtype=torch.float32))


def write_capture(
    path: Path,
    cameras: int = 5,
    frames: int = 6,
    width: int = 64,
    height: int = 48,
    event: range = range(0),
    late: Mapping[str, float] | None = None,
) -> list[Camera]:
    """Render the synthetic scene to `path`: ims/<camera>/<frame>.jpg and train_meta.json.

    In the frames of `event` the ball of `event_splats` is there too. The cameras of `late` take their frames so many
    frames later than the others, and sync.json says so.
    """
    if late:
        path.mkdir(parents=True, exist_ok=True)
        (path / "sync.json").write_text(json.dumps({"frames": late}))
    views = ring_of_cameras(cameras, width, height)
    static, dynamic = synthetic_scene()
    with_ball = joined(static, event_splats())
    meta: dict[str, object] = {"w": width, "h": height, "fn": [], "k": [], "w2c": [], "cam_id": []}
    rows: dict[str, list[object]] = {"fn": [], "k": [], "w2c": [], "cam_id": []}
    for frame in range(frames):
        for view in views:
            time = (frame + (late or {}).get(view.name, 0.0)) / max(1, frames - 1)
            shown = with_ball if frame in event else static
            picture = rasterize_reference(shown, dynamic, View(view, time, gradients="none")).rgb.clamp(0, 1)
            pixels = (picture.permute(1, 2, 0).numpy() * 255).round().astype(np.uint8)
            file = path / "ims" / view.name / f"{frame:06d}.jpg"
            file.parent.mkdir(parents=True, exist_ok=True)
            Image.fromarray(pixels).save(file, quality=95)
        rows["fn"].append([f"{view.name}/{frame:06d}.jpg" for view in views])
        rows["k"].append([[[v.fx, 0, v.cx], [0, v.fy, v.cy], [0, 0, 1]] for v in views])
        rows["w2c"].append([v.world_to_camera.tolist() for v in views])
        rows["cam_id"].append([int(v.name) for v in views])
    (path / "train_meta.json").write_text(json.dumps(meta | rows))
    return views
