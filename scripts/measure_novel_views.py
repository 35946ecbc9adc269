"""The share of views from beside the cameras that a scene cannot show, in its captured space with and without limits.

    python -m scripts.measure_novel_views RUN --views 49 --pictures out

Draws eyes at random, with equal chances over azimuths, elevations and distances, which look at the centre as the viewer
does, and tells in how many more than a share of the picture is uncovered (alpha below 0.5), and is not seen well
(hgs_core/fit/seen_share.py). With --pictures, their contact sheets.
"""

from __future__ import annotations

import argparse
import dataclasses
import math
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import torch
from PIL import Image

from hgs_core.codec import decode_scene, load_manifest
from hgs_core.codec.format.captured_space import CapturedSpace, Place
from hgs_core.codec.format.manifest import Manifest
from hgs_core.fit.find_seen_limits import view_from, with_seen_limits
from hgs_core.fit.seen_share import SeenShare
from hgs_core.render.scene_picture import scene_picture
from hgs_core.runs.run_folder import RunFolder
from hgs_core.scene.camera import Camera

WIDTH = 192  # pixels of a picture in a sheet
COLUMNS = 7
TOO_MUCH = 0.05  # share of a picture


def main() -> None:
    """Measure, and print a line for the box and one for the limits."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path)
    parser.add_argument("--views", type=int, default=49)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--pictures", type=Path, help="folder for box.png and limits.png, and small ones, .webp")
    options = parser.parse_args()
    folder = RunFolder(options.run)
    manifest, scene = load_manifest(folder.scene), decode_scene(folder.scene)
    if manifest.captured_space is None:
        parser.error(f"{options.run} has no captured space: nobody knows from where it may be looked at")
    held_out = folder.read_spec().config.capture.hold_out
    trained = [camera for camera in manifest.cameras if camera.name not in held_out]
    box, begun = dataclasses.replace(manifest.captured_space, seen=None), time.process_time()
    limits = with_seen_limits(box, manifest.center, manifest.up, scene=scene, cameras=trained)
    print(f"limits found in {time.process_time() - begun:.1f} s of processor time")
    seen, tensors = SeenShare(scene, trained), scene.map(torch.from_numpy)
    for name, space in (("box", box), ("limits", limits)):
        pictures, uncovered, unseen = [], [], []
        for eye in _eyes(manifest, space, options.views, options.seed):
            drawn = scene_picture(tensors, eye, (scene.start + scene.end) / 2, rig=manifest.rig)
            pictures.append((drawn.rgb.clamp(0, 1) * 255).byte().permute(1, 2, 0).numpy())
            uncovered.append(float((drawn.alpha < 0.5).float().mean()))
            unseen.append(1 - seen.of(eye))
        counts = [int((np.array(shares) > TOO_MUCH).sum()) for shares in (uncovered, unseen)]
        means = [np.mean(shares) for shares in (uncovered, unseen)]
        print(
            f"{name}: over {TOO_MUCH:.0%} uncovered in {counts[0]} of {options.views} views (mean {means[0]:.1%}), "
            f"not seen well in {counts[1]} (mean {means[1]:.1%})"
        )
        if options.pictures is not None:
            options.pictures.mkdir(parents=True, exist_ok=True)
            sheet = Image.fromarray(_sheet(pictures))
            sheet.save(options.pictures / f"{name}.png")
            small = sheet.resize((sheet.width * 2 // 3, sheet.height * 2 // 3), Image.Resampling.LANCZOS)
            small.save(options.pictures / f"{name}.webp", quality=50, method=6)


def _eyes(manifest: Manifest, space: CapturedSpace, count: int, seed: int) -> Iterator[Camera]:
    """Yield eyes inside the space, with the lens of the camera with which the viewer begins."""
    numbers = np.random.default_rng(seed)
    half = space.azimuth or math.pi
    first = manifest.cameras[0].scaled(WIDTH / manifest.cameras[0].width)
    usual = float(np.linalg.norm(first.position - np.array(manifest.center)))
    while count:
        place = Place(*(float(numbers.uniform(*ends)) for ends in ((-half, half), space.elevation, space.distance)))
        if space.holds(place):
            count -= 1
            like = dataclasses.replace(first, near=first.near * place.distance / usual)
            yield view_from(space, place, manifest.center, manifest.up, like)


def _sheet(pictures: list[np.ndarray]) -> np.ndarray:
    blank = [np.zeros_like(pictures[0])] * (-len(pictures) % COLUMNS)
    tiles = [*pictures, *blank]
    rows = [np.concatenate(tiles[i : i + COLUMNS], axis=1) for i in range(0, len(tiles), COLUMNS)]
    return np.concatenate(rows)


if __name__ == "__main__":
    main()
