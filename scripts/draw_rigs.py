"""A held-out camera's picture beside those of runs that were trained from other numbers of cameras.

    python -m scripts.draw_rigs CAPTURE RUN... --camera cam00 --out docs/images/rigs.webp

Two rows from left to right, first the capture's own picture of the middle frame.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import torch
from PIL import Image

from hgs_core.capture.open import open_capture
from hgs_core.codec import decode_scene, load_manifest
from hgs_core.render.scene_picture import scene_picture
from hgs_core.runs.run_folder import RunFolder

ROWS = 2
WIDTH = 400  # pixels of a picture
QUALITY = 80  # WebP


def main() -> None:
    """Draw the picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("capture", type=Path)
    parser.add_argument("runs", type=Path, nargs="+")
    parser.add_argument("--camera", required=True)
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    capture = open_capture(options.capture)
    frame = len(capture.times) // 2
    pictures = [capture.frame(capture.camera_index(options.camera), frame)]
    for run in options.runs:
        folder = RunFolder(run)
        manifest, scene = load_manifest(folder.scene), decode_scene(folder.scene).map(torch.from_numpy)
        camera = next(camera for camera in manifest.cameras if camera.name == options.camera)
        shown = scene_picture(scene, camera, float(capture.times[frame]), rig=manifest.rig).rgb.clamp(0, 1)
        pictures.append((shown * 255).round().byte().permute(1, 2, 0).numpy())
    height, width = pictures[0].shape[:2]
    size = (WIDTH, round(WIDTH * height / width))
    columns = -(-len(pictures) // ROWS)
    sheet = Image.new("RGB", (columns * size[0], ROWS * size[1]))
    for place, picture in enumerate(pictures):
        row, column = divmod(place, columns)
        small = Image.fromarray(np.ascontiguousarray(picture)).resize(size, Image.Resampling.LANCZOS)
        sheet.paste(small, (column * size[0], row * size[1]))
    sheet.save(options.out, quality=QUALITY, method=6)


if __name__ == "__main__":
    main()
