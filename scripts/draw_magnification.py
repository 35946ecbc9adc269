"""Parts of pictures twice as large, drawn without magnification and with it.

    python -m scripts.draw_magnification RUN CAMERA --out docs/images/magnification.webp

Columns: from the camera's place, from a third and from two thirds of the way to what moves. The upper row is drawn
without magnification, the lower row with it. A part is where the two differ most.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import torch
from PIL import Image
from torch.nn.functional import avg_pool2d

from hgs_core.codec import decode_scene, load_manifest
from hgs_core.evaluate.magnified import WALKS, depth_of_movers, walked
from hgs_core.render.scene_picture import scene_picture
from hgs_core.runs.run_folder import RunFolder

FACTOR = 2
WIDTH, HEIGHT = 400, 300  # pixels of a part
STEP = 50  # pixels between the places that are tried
QUALITY = 80  # WebP


def main() -> None:
    """Draw the picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path)
    parser.add_argument("camera")
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    folder = RunFolder(options.run)
    manifest, scene = load_manifest(folder.scene), decode_scene(folder.scene).map(torch.from_numpy)
    camera = next(camera for camera in manifest.cameras if camera.name == options.camera)
    seconds = (scene.start + scene.end) / 2
    way = depth_of_movers(scene, camera, seconds, manifest.center)
    columns = []
    for share in (0, *WALKS):
        eye = walked(camera, share, way).scaled(FACTOR)
        rows = [scene_picture(scene, eye, seconds, rig=rig).rgb.clamp(0, 1) for rig in ((), manifest.rig)]
        apart = avg_pool2d((rows[0] - rows[1]).square().mean(dim=0)[None], (HEIGHT, WIDTH), STEP)[0]
        top, left = (STEP * place for place in divmod(int(apart.argmax()), apart.shape[1]))
        columns.append(torch.cat([row[:, top : top + HEIGHT, left : left + WIDTH] for row in rows], dim=1))
    pixels = (torch.cat(columns, dim=2) * 255).round().byte().permute(1, 2, 0)
    Image.fromarray(np.ascontiguousarray(pixels.numpy())).save(options.out, quality=QUALITY, method=6)


if __name__ == "__main__":
    main()
