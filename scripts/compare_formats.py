"""How like a scene its exports are: bytes, and PSNR of their pictures against its own; prints a Markdown table.

    python -m scripts.compare_formats SOURCE --out FOLDER [--fps 5] [--size 640]

SOURCE is a run, a scene folder or a file of splats. Files of a moment hold the middle of the scene; of those that
move, every frame of `--fps` is drawn. FOLDER keeps the files and, of each, the scene's picture beside the file's.
"""

from __future__ import annotations

import argparse
import dataclasses
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from PIL import Image
from torch import Tensor

from hgs_core.base.arrays import Floats
from hgs_core.base.progress import silent
from hgs_core.fit.orbit_cameras import orbit_cameras
from hgs_core.interchange import IMPORTED, export_scene, export_sequence, import_scene
from hgs_core.metrics.psnr import psnr
from hgs_core.render.scene_picture import scene_picture
from hgs_core.runs.source import Source, open_source
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import HybridScene

__all__ = ["Kept", "compared", "markdown"]

CAMERAS = 8  # drawn cameras
STILL: tuple[tuple[str, dict[str, Any]], ...] = (
    ("still.ply", {}),
    ("still.splat", {}),
    ("2.spz", {"version": 2}),
    ("3.spz", {"version": 3}),
    ("4.spz", {"version": 4}),
    ("still.glb", {}),
    ("still.sog", {}),
)
MOVING = ("moving.ply", "moving.4dgs")


@dataclass(frozen=True)
class Kept:
    """The remains of a scene in one file."""

    name: str
    size: int  # bytes
    worst: float  # PSNR of its worst picture, dB
    mean: float  # mean decibels of all pictures


def compared(source: Source, folder: Path, frame_rate: float, size: int) -> list[Kept]:
    """Export a scene in every format that can be imported, draw the imported scenes, and compare them with it."""
    scene, cameras = source.scene, source.cameras or orbit_cameras(source.scene).whole
    step = max(1, len(cameras) // CAMERAS)
    views = [camera.within(size) for camera in cameras[::step][:CAMERAS]]
    middle = (scene.start + scene.end) / 2
    moves = scene.dynamic_splats > 0
    folder.mkdir(parents=True, exist_ok=True)
    kept = []
    for name, options in STILL:
        path = folder / name
        export_scene(scene, path, cameras=cameras, time=middle if moves else None, **options)
        back = import_scene(path).scene
        kept.append(_kept(path, scene, back, views, [(middle, 0.0)]))
    if not moves:
        return kept
    length = scene.end - scene.start
    times = scene.start + np.arange(int(length * frame_rate + 1e-6) + 1) / frame_rate
    for name in (*MOVING, "frames"):
        path = folder / name
        if Path(name).suffix in IMPORTED:
            export_scene(scene, path, cameras=cameras)
        else:
            export_sequence(scene, path, frame_rate, silent)
        back = import_scene(path, length, frame_rate).scene
        kept.append(_kept(path, scene, back, views, [(float(time), float(time) - scene.start) for time in times]))
    return kept


def _kept(
    path: Path,
    scene: HybridScene[Floats],
    back: HybridScene[Floats],
    views: Sequence[Camera],
    moments: Sequence[tuple[float, float]],
) -> Kept:
    """Compare at moments of the scene and of the imported one, seconds."""
    found = []
    for number, (before, after) in enumerate(moments):
        for camera in views:
            pictures = _drawn(scene, camera, before, scene), _drawn(back, camera, after, scene)
            found.append(psnr(pictures[1], pictures[0]))
            if number == len(moments) // 2 and camera is views[0]:
                beside = (torch.cat(pictures, dim=2).permute(1, 2, 0) * 255).round().to(torch.uint8).numpy()
                Image.fromarray(beside).save(path.with_name(f"{path.name}.png"))
    files = [path] if path.is_file() else sorted(path.iterdir())
    return Kept(path.name, sum(file.stat().st_size for file in files), min(found), float(np.mean(found)))


def _drawn(scene: HybridScene[Floats], camera: Camera, seconds: float, like: HybridScene[Floats]) -> Tensor:
    """Draw a scene, antialiased and before the background as the one that was exported."""
    as_exported = dataclasses.replace(scene, background=like.background, antialiased=like.antialiased)
    return scene_picture(as_exported.map(torch.from_numpy), camera, seconds).rgb.clamp(0, 1)


def markdown(kept: Sequence[Kept]) -> str:
    """Return the table."""
    lines = ["| file | bytes | PSNR, worst, mean |", "|---|---|---|"]
    lines += [f"| {one.name} | {one.size:,} | {one.worst:.1f}, {one.mean:.1f} dB |" for one in kept]
    return "\n".join(lines)


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", type=Path)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--fps", type=float, default=5.0)
    parser.add_argument("--size", type=int, default=640, help="longer side of the pictures, pixels")
    options = parser.parse_args()
    found: Path = options.source
    source = Source(import_scene(found).scene, (), 30.0) if found.is_file() else open_source(found)
    with tempfile.TemporaryDirectory() as folder:
        print(markdown(compared(source, options.out or Path(folder), options.fps, options.size)))


if __name__ == "__main__":
    main()
