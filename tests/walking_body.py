"""A body that walks among three cameras far apart, and the masks that they would have of it."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageFilter

from hgs_core.check.silhouette_pairs import Silhouettes
from hgs_core.check.silhouettes import silhouettes_of
from hgs_core.scene.camera import Camera, looking_at

__all__ = ["CAMERAS", "MOMENTS", "body", "mask_of", "shapes_of", "write_walk"]

MOMENTS = 24

CAMERAS = tuple(
    Camera(f"cam{number}", 320, 240, 250.0, 250.0, 160.0, 120.0, looking_at(np.array(place), np.array((0.0, 0.0, 0.0))))
    for number, place in enumerate(((0.0, -0.3, 3.0), (2.8, -0.8, -1.4), (-2.5, 0.2, -1.7)))
)

_SURFACE = np.random.default_rng(1).normal(size=(3000, 3))
_SURFACE /= np.linalg.norm(_SURFACE, axis=1, keepdims=True)


def body(second: float, side: float = 1.0) -> npt.NDArray[np.float64]:
    """Points [N, 3] of an egg's surface that walks on a bow; `side` -1 gives another one that walks elsewhere."""
    angle = 2 * np.pi * second * side
    middle = side * np.array((0.5 * np.sin(angle), 0.1 * np.sin(2 * angle), 0.4 * np.cos(angle)))
    return np.asarray(_SURFACE * (0.15, 0.5, 0.2) + middle)


def mask_of(camera: Camera, points: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
    """The mask [H, W] of a body's points: their pixels, closed to an area."""
    pixels = camera.project(points)[0].round().astype(int)
    inside = ((pixels >= 0) & (pixels < (camera.width, camera.height))).all(axis=1)
    mask = np.zeros((camera.height, camera.width), np.uint8)
    mask[pixels[inside, 1], pixels[inside, 0]] = 255
    closed = Image.fromarray(mask).filter(ImageFilter.MaxFilter(7)).filter(ImageFilter.MinFilter(7))
    return np.array(closed) > 0


@cache
def shapes_of(camera: int) -> Silhouettes:
    """The silhouettes of the walking body in a camera, at all moments."""
    masks = [mask_of(CAMERAS[camera], body(second)) for second in np.linspace(0, 1, MOMENTS)]
    return Silhouettes.of([silhouettes_of(mask, CAMERAS[camera]) for mask in masks])


def write_walk(folder: Path, frames: int = 6) -> None:
    """Write a capture of the walk in the PanopticSports layout: a grey body in a room of two colours, and its masks."""
    meta: dict[str, object] = {"w": CAMERAS[0].width, "h": CAMERAS[0].height}
    rows: dict[str, list[list[object]]] = {"fn": [], "k": [], "w2c": [], "cam_id": []}
    for frame in range(frames):
        for row in rows.values():
            row.append([])
        for number, camera in enumerate(CAMERAS):
            mask = mask_of(camera, body(frame / (3 * frames)))
            picture = np.full((camera.height, camera.width, 3), (200, 180, 160), np.uint8)
            picture[camera.height // 2 :] = (60, 90, 60)
            picture[mask] = 120
            for kind, pixels in (("ims", picture), ("seg", mask.astype(np.uint8) * 255)):
                file = folder / kind / str(number) / f"{frame:06d}.png"
                file.parent.mkdir(parents=True, exist_ok=True)
                Image.fromarray(pixels).save(file)
            k = [[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]]
            values = f"{number}/{frame:06d}.png", k, camera.world_to_camera.tolist(), number
            for row, value in zip(rows.values(), values, strict=True):
                row[-1].append(value)
    (folder / "train_meta.json").write_text(json.dumps(meta | rows))
