"""What is seen from where no camera stood, and which splats show there.

    .venv/bin/python -m scripts.experiments.outside_views RUN [RUN ...] [--pictures FILE.webp] [--groups]

Every run's trained scene is scored (frames 5, 20, 35 and 50, or the first) on its training cameras and on those held
out, with how many degrees each is off the nearest of the former, seen from what they look at. `--pictures` draws a row
of pictures per run from outside, with the near plane of the first camera, as the viewer does. `--groups` says of the
first run's static splats how many training cameras show them (a blending weight of 0.02 and more), what they are of the
pictures inside and outside, and what the scores lose without them.
"""

from __future__ import annotations

import argparse
import dataclasses
import math
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch
from PIL import Image

import hgs_core as hgs
from hgs_core.codec.encoder.viewpoint import find_viewpoint
from hgs_core.render.contributions import contributions
from hgs_core.runs.encode_inputs import trained_scene, views_of_run
from hgs_core.runs.run_folder import RunFolder

__all__ = ["Rig", "degrees_outside"]

_FRAMES = (5, 20, 35, 50)
_OUTSIDE = ((-67.0, 5.0), (-67.0, 25.0), (52.0, 5.0), (76.0, 5.0))  # azimuth and elevation, degrees
_SHOWN = 0.02  # blending weight
_GROUPS = ((0, 0), (1, 1), (2, 2), (3, 5), (6, 10_000))

Doubles = npt.NDArray[np.float64]
Scene = hgs.HybridScene[npt.NDArray[np.float32]]


@dataclasses.dataclass(frozen=True)
class Rig:
    """A run with its cameras, and directions from the point that they look at."""

    scene: Scene
    cameras: tuple[hgs.Camera, ...]
    trained: tuple[int, ...]
    truth: hgs.Capture
    center: Doubles
    up: Doubles
    front: Doubles  # the middle of all cameras, at right angles to `up`

    @staticmethod
    def of(run: Path) -> Rig:
        folder = RunFolder(run)
        scene = trained_scene(folder)
        views = views_of_run(folder, folder.read_spec(), scene)
        assert views.capture is not None
        found = find_viewpoint(views.cameras, np.asarray(scene.segments[0].dynamic.motion, np.float64)[:, 0])
        center, up = np.array(found.center), np.array(found.up)
        front = np.mean([camera.position for camera in views.cameras], axis=0) - center
        front -= up * (front @ up)
        return Rig(scene, views.cameras, tuple(views.trained), views.capture, center, up, front / np.linalg.norm(front))

    @property
    def frames(self) -> list[int]:
        return [frame for frame in _FRAMES if frame < len(self.truth.times)] or [0]

    def direction(self, camera: hgs.Camera) -> Doubles:
        offset = camera.position - self.center
        return np.asarray(offset / np.linalg.norm(offset))

    def outside(self) -> list[hgs.Camera]:
        """Return cameras at the first one's distance, with its near plane."""
        first = self.cameras[0]
        distance = float(np.linalg.norm(first.position - self.center))
        found = []
        for azimuth, elevation in np.deg2rad(_OUTSIDE):
            ahead = math.cos(azimuth) * self.front + math.sin(azimuth) * np.cross(self.up, self.front)
            direction = math.cos(elevation) * ahead + math.sin(elevation) * self.up
            right = np.cross(-direction, self.up)
            right /= np.linalg.norm(right)
            pose = np.eye(4)
            pose[:3, :3] = [right, np.cross(-direction, right), -direction]
            pose[:3, 3] = -pose[:3, :3] @ (self.center + distance * direction)
            found.append(dataclasses.replace(first, world_to_camera=pose))
        return found

    def picture(self, scene: Scene, camera: hgs.Camera, seconds: float) -> Doubles:
        segment = scene.segment_at(seconds)
        drawn = hgs.rasterize(
            scene.static.map(torch.from_numpy),
            segment.dynamic.map(torch.from_numpy),
            camera,
            segment.normalised(seconds),
            gradients="none",
            background=scene.background,
            antialiased=scene.antialiased,
        )
        return drawn.rgb.clamp(0, 1).permute(1, 2, 0).double().numpy()

    def psnr(self, scene: Scene, cameras: Iterable[int]) -> float:
        """Return the mean over cameras of the PSNR of all frames together."""
        found = []
        for i in cameras:
            errors = [
                ((self.picture(scene, self.cameras[i], self.truth.times[f]) - self.truth.frame(i, f) / 255) ** 2).mean()
                for f in self.frames
            ]
            found.append(-10 * math.log10(np.mean(errors)))
        return float(np.mean(found))

    def weights(self, cameras: Sequence[hgs.Camera]) -> tuple[Doubles, Doubles]:
        """Return of every static splat, in each camera [K, N], the largest total and peak weight of the frames."""
        count, total, peak = len(self.scene.static), [], []
        for camera in cameras:
            shown = []
            for frame in self.frames:
                segment = self.scene.segment_at(self.truth.times[frame])
                sets = self.scene.static.map(torch.from_numpy), segment.dynamic.map(torch.from_numpy)
                moment = segment.normalised(self.truth.times[frame])
                shown.append(contributions(*sets, camera, moment, antialiased=self.scene.antialiased))
            total.append(np.max([one.total[:count] for one in shown], axis=0))
            peak.append(np.max([one.peak[:count] for one in shown], axis=0))
        return np.array(total), np.array(peak)


def degrees_outside(direction: Doubles, others: Sequence[Doubles]) -> float:
    """Return the angle from a direction to the nearest of the others; unit vectors."""
    return math.degrees(math.acos(min(1.0, max(float(direction @ other) for other in others))))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", type=Path, nargs="+")
    parser.add_argument("--pictures", type=Path)
    parser.add_argument("--groups", action="store_true")
    options = parser.parse_args()
    rigs = [Rig.of(run) for run in options.runs]
    trained = [rigs[0].direction(rigs[0].cameras[i]) for i in rigs[0].trained]
    held = [i for i in range(len(rigs[0].cameras)) if i not in rigs[0].trained]
    angles = [degrees_outside(rigs[0].direction(rigs[0].cameras[i]), trained) for i in held]
    names = [f"{rigs[0].cameras[i].name}, {angle:.0f} degrees off" for i, angle in zip(held, angles, strict=True)]
    print(f"| run | static | dynamic | training cameras | {' | '.join(names)} |\n|---|---|---|---|{'---|' * len(held)}")
    for run, rig in zip(options.runs, rigs, strict=True):
        scores = " | ".join(f"{rig.psnr(rig.scene, [i]):.2f}" for i in held)
        counts = f"{len(rig.scene.static)} | {rig.scene.dynamic_splats}"
        print(f"| {run.name} | {counts} | {rig.psnr(rig.scene, rig.trained):.2f} | {scores} |", flush=True)
    if options.groups:
        groups(rigs[0], held)
    if options.pictures:
        moment = float(np.median(rigs[0].truth.times))
        rows = [np.concatenate([rig.picture(rig.scene, c, moment) for c in rigs[0].outside()], axis=1) for rig in rigs]
        picture = Image.fromarray((np.concatenate(rows) * 255).round().astype(np.uint8))
        picture.save(options.pictures, quality=70, method=6)


def groups(rig: Rig, held: Sequence[int]) -> None:
    inside, peak = rig.weights([rig.cameras[i] for i in rig.trained])
    outside = rig.weights(rig.outside())[0]
    shown = (peak >= _SHOWN).sum(axis=0)
    whole = rig.psnr(rig.scene, rig.trained), rig.psnr(rig.scene, held)
    print("\n| cameras that show it | statics | of pictures inside | outside | lost without: training | held out |")
    print("|---|---|---|---|---|---|")
    for low, high in _GROUPS:
        group = (shown >= low) & (shown <= high)
        left = dataclasses.replace(rig.scene, static=rig.scene.static.take(np.flatnonzero(~group)))
        name = str(low) if low == high else f"{low} to {high}" if high < 100 else f"{low} and more"
        shares = [weight[:, group].sum() / weight.sum() for weight in (inside, outside)]
        losses = [before - rig.psnr(left, which) for before, which in zip(whole, (rig.trained, held), strict=True)]
        cells = [f"{share:.2%}" for share in shares] + [f"{loss:.2f} dB" for loss in losses]
        print(f"| {name} | {group.sum()} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
