"""Write tests/vectors/pictures: a small scene, and how it looks from some cameras at some times, for other players.

The pictures are the float64 reference backend's of the decoded scene. Run it after a change of the format or of
docs/numerics.md:

    .venv/bin/python -m scripts.make_picture_vectors
"""

from __future__ import annotations

import dataclasses
import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import torch
from PIL import Image

from hgs_core.codec import decode_scene, encode_scene
from hgs_core.render import rasterize
from hgs_core.scene import HybridScene, Segment
from hgs_core.scene.camera import Camera
from tests.chirality import letters, views

OUT = Path(__file__).resolve().parent.parent / "tests" / "vectors" / "pictures"
BACKGROUND = (0.1, 0.15, 0.2)
WIDTH, HEIGHT = 160, 120
DURATION = 2.0  # seconds


def scene() -> HybridScene[np.ndarray]:
    """Return the letters L and R and an arrow, of which the R rises, turns and fades."""
    still = letters(moving=True)
    dynamic = still.segments[0].dynamic
    motion, rotation = dynamic.motion.copy(), dynamic.rotation.copy()
    motion[:, 1] = (0.0, -0.5, 0.0)  # up: y points down
    motion[:, 2] = (0.0, 0.0, 0.4)
    rotation[:, 1] = (0.0, 0.3, 0.0, 0.2)
    fading = np.full(len(motion), 1.5, np.float32)
    moved = dataclasses.replace(dynamic, motion=motion, rotation=rotation, time_log_precisions=fading)
    return HybridScene(still.static, (Segment(0.0, DURATION, moved),), BACKGROUND)


def cases() -> list[tuple[str, Camera, float, bool]]:
    """Return name, camera, seconds and whether antialiased of each picture."""
    front, above = views(WIDTH, HEIGHT)
    # As an eye of a headset: its middle is not where it looks.
    eye = dataclasses.replace(above, name="eye", fx=120.0, fy=110.0, cx=100.5, cy=50.25)
    return [
        ("front", front, 1.0, False),
        ("front-earlier", front, 0.25, False),
        ("above", above, 1.5, False),
        ("eye-antialiased", eye, 1.0, True),
    ]


def picture(camera: Camera, seconds: float, *, antialiased: bool) -> np.ndarray:
    """Return the reference's picture of the scene that lies in OUT, [H, W, 3] from 0 to 1."""
    decoded = decode_scene(OUT).map(lambda array: torch.tensor(array, dtype=torch.float64))
    segment = decoded.segment_at(seconds)
    render = rasterize(
        decoded.static,
        segment.dynamic,
        camera,
        segment.normalised(seconds),
        background=BACKGROUND,
        backend="reference",
        gradients="none",
        antialiased=antialiased,
    )
    rgb: np.ndarray = render.rgb.permute(1, 2, 0).numpy()
    return rgb


def document() -> list[dict[str, Any]]:
    """Return the content of pictures.json."""
    return [
        {
            "picture": f"{name}.png",
            "time": seconds,
            "antialiased": antialiased,
            "camera": camera.to_json(),
        }
        for name, camera, seconds, antialiased in cases()
    ]


def main() -> None:
    shutil.rmtree(OUT, ignore_errors=True)
    cameras = [camera for _, camera, _, _ in cases()[::2]]
    encode_scene(scene(), OUT, cameras=cameras, times=np.linspace(0, DURATION, 9), title="Letters")
    for name, camera, seconds, antialiased in cases():
        rounded = np.rint(np.clip(picture(camera, seconds, antialiased=antialiased), 0, 1) * 255).astype(np.uint8)
        Image.fromarray(rounded).save(OUT / f"{name}.png", optimize=True)
    (OUT / "pictures.json").write_text(json.dumps(document(), indent=1) + "\n")


if __name__ == "__main__":
    main()
