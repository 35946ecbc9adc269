"""A red ball that moves in a round green room, filmed by three cameras far apart or by many beside each other."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path

import numpy as np

from hgs_core.codec import Manifest, encode_scene
from hgs_core.fit.find_seen_limits import with_seen_limits
from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats
from hgs_core.scene.camera import Camera, looking_at
from tests.web_client.conftest import HEIGHT, WIDTH

__all__ = ["ARC", "AROUND", "camera_at", "encode_room", "green", "red"]

AROUND = (0, 120, 240)  # degrees
ARC = tuple(range(-80, 81, 20))
DISTANCE, WALL = 3.0, 4.0  # radii of the rig and of the room


def camera_at(degrees: float) -> Camera:
    """Return a camera that looks at the ball from its left, seen from above."""
    angle = math.radians(degrees)
    place = (DISTANCE * math.sin(angle), 0.0, -DISTANCE * math.cos(angle))
    return Camera(f"{degrees:g}", WIDTH, HEIGHT, 300.0, 300.0, WIDTH / 2, HEIGHT / 2, looking_at(place, np.zeros(3)))


def encode_room(out: Path, azimuths: tuple[int, ...]) -> Manifest:
    """Encode the room as filmed from these directions, degrees."""
    angles, heights = np.meshgrid(np.linspace(0, 2 * math.pi, 60, endpoint=False), np.linspace(-3, 3, 16))
    walls = np.stack([WALL * np.sin(angles), heights, -WALL * np.cos(angles)], -1).reshape(-1, 3)
    count = len(walls)
    static = StaticSplats(
        _single(walls),
        _single(np.full((count, 3), math.log(0.3))),
        _single(np.tile([1, 0, 0, 0], (count, 1))),
        _single(np.full(count, 4.0)),
        _single(np.tile([0.1, 0.8, 0.1], (count, 1))),
    )
    motion = np.zeros((1, 4, 3))
    motion[:, 1, 1] = 0.1
    ball = DynamicSplats(
        _single(motion),
        _single([[[1, 0, 0, 0], [0, 0, 0, 0]]]),
        _single(np.full((1, 3), math.log(0.3))),
        _single([4.0]),
        _single([0.5]),
        _single([-4.0]),
        _single([[0.9, 0.1, 0.1]]),
    )
    scene = HybridScene(static, (Segment(0.0, 1.0, ball),))
    rig = [camera_at(degrees) for degrees in azimuths]
    return encode_scene(
        scene,
        out,
        cameras=rig,
        times=np.linspace(0.0, 1.0, 31),
        title="Room",
        trained=rig,
        narrowed=partial(with_seen_limits, scene=scene, cameras=rig),
    )


def green(picture: np.ndarray) -> float:
    """Return the share of the picture [H, W, 3], 8 bits, that is greener than the soft background."""
    r, g, b = np.moveaxis(picture.astype(np.float64), -1, 0)
    return float((g - np.maximum(r, b) > 12).mean())


def red(picture: np.ndarray) -> float:
    """Return the share of the picture [H, W, 3], 8 bits, that is red."""
    r, g, b = np.moveaxis(picture.astype(np.float64), -1, 0)
    return float((r - np.maximum(g, b) > 60).mean())


def _single(values: object) -> np.ndarray:
    return np.ascontiguousarray(values, np.float32)
