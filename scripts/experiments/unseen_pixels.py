"""How much of a held-out camera's error lies where few training cameras look.

    .venv/bin/python -m scripts.experiments.unseen_pixels RUN [--truth FOLDER] [--frames 5,30,55]

Every pixel of the first held-out camera is put at its rendered depth and projected into every training camera. A
training camera sees the same surface if its own rendered depth there agrees within 5 %. Pixels are grouped by how many
cameras see them; of each group the table says its share of the pixels, of the squared error, and its PSNR.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch
from PIL import Image

import hgs_core as hgs
from hgs_core.runs.run_folder import RunFolder

__all__ = ["times_seen"]

_AGREEMENT = 0.05  # of the depth
_GROUPS = (("none", 0, 0), ("1 or 2", 1, 2), ("3 to 5", 3, 5), ("6 or more", 6, 10_000))

Doubles = npt.NDArray[np.float64]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path)
    parser.add_argument("--truth", type=Path, help="pictures <camera>/<FFFF>.png instead of the capture's")
    parser.add_argument("--frames", default="5,30,55")
    options = parser.parse_args()
    spec = RunFolder(options.run).read_spec()
    capture = spec.open_capture()
    manifest = hgs.load_manifest(options.run / "scene")
    scene = hgs.decode_scene(options.run / "scene").map(torch.from_numpy)
    cameras = {camera.name: camera for camera in manifest.cameras}
    held_out = cameras[spec.config.capture.hold_out[0]]
    trained = [camera for camera in manifest.cameras if camera.name not in spec.config.capture.hold_out]

    def drawn(camera: hgs.Camera, seconds: float) -> tuple[Doubles, Doubles]:
        """Return the picture [H, W, 3] and the depth [H, W]."""
        segment = scene.segment_at(seconds)
        picture = hgs.rasterize(
            scene.static,
            segment.dynamic,
            camera,
            segment.normalised(seconds),
            depth=True,
            gradients="none",
            background=scene.background,
            antialiased=scene.antialiased,
        )
        assert picture.depth is not None
        rgb = picture.rgb.clamp(0, 1).permute(1, 2, 0).double().numpy()
        return rgb, (picture.depth / picture.alpha.clamp(min=1e-6)).double().numpy()

    print("| frame | training cameras that see the pixel | pixels | squared error | PSNR |\n|---|---|---|---|---|")
    for frame in (int(text) for text in options.frames.split(",")):
        seconds = float(capture.times[frame])
        rgb, depth = drawn(held_out, seconds)
        if options.truth:
            truth = np.asarray(Image.open(options.truth / held_out.name / f"{frame:04d}.png").convert("RGB"))
        else:
            truth = capture.frame(capture.camera_index(held_out.name), frame)
        error = ((rgb - truth / 255) ** 2).mean(axis=2)
        seen = times_seen(held_out, depth, [(camera, drawn(camera, seconds)[1]) for camera in trained])
        for name, low, high in _GROUPS:
            group = (seen >= low) & (seen <= high)
            psnr = -10 * np.log10(error[group].mean())
            print(f"| {frame} | {name} | {group.mean():.1%} | {error[group].sum() / error.sum():.1%} | {psnr:.1f} dB |")


def times_seen(camera: hgs.Camera, depth: Doubles, others: list[tuple[hgs.Camera, Doubles]]) -> npt.NDArray[np.int64]:
    """Return [H, W] how many of the other cameras, each with its depth [H, W], see the surface that `camera` sees."""
    rows, columns = np.indices(depth.shape)
    pixels = np.stack([columns.ravel() + 0.5, rows.ravel() + 0.5], axis=1)
    points = camera.position + camera.rays(pixels) * depth.reshape(-1, 1)
    count = np.zeros(depth.size, np.int64)
    for other, other_depth in others:
        places, z = other.project(points)
        inside = (z > other.near) & (places >= 0).all(axis=1) & (places < (other.width, other.height)).all(axis=1)
        at = places[inside].astype(np.int64)
        count[inside] += np.abs(other_depth[at[:, 1], at[:, 0]] - z[inside]) < _AGREEMENT * z[inside]
    return count.reshape(depth.shape)


if __name__ == "__main__":
    main()
