"""What first-order spherical harmonics of the static splats would bring.

    .venv/bin/python -m scripts.experiments.view_dependent_colour RUN [--truth FOLDER] [--steps 1500]

The scene of a finished run stays as it is but for the colours of its statics. They are trained on, once as they are
and once with three more coefficients per channel that follow the direction from the camera, on the same views in the
same order, at half the size. Every camera keeps the affine colour map that fits it best, where the run learned some.
Both are scored on the cameras that the run held out.
"""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

import hgs_core as hgs
from hgs_core.evaluate.truth import Truth
from hgs_core.points.near_plane import with_near_planes
from hgs_core.points.point_cloud import PointCloud
from hgs_core.render.colour_affine import colour_affine
from hgs_core.runs.run_folder import RunFolder
from hgs_core.scene.files import load_scene
from hgs_core.train.loss import photometric_loss

_RATE = 2e-3  # of colours and of harmonics at the start; it falls to nothing
_MEMORY = 0.95  # of a camera's colour map from visit to visit
_SCORED = 8  # moments


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path)
    parser.add_argument("--truth", type=Path, help="pictures <camera>/<FFFF>.png instead of the capture's")
    parser.add_argument("--steps", type=int, default=1500)
    options = parser.parse_args()
    print("| colours of statics | training PSNR | held-out PSNR | after colour maps |\n|---|---|---|---|")
    for harmonics in (False, True):
        colours = _Colours(options.run, options.truth, harmonics)
        if not harmonics:
            print("| as trained | | {:.2f} | {:.2f} |".format(*colours.scores()), flush=True)
        trained = colours.train(options.steps)
        name = "with first-order harmonics" if harmonics else f"{options.steps:,} further steps"
        print("| {} | {:.2f} | {:.2f} | {:.2f} |".format(name, trained, *colours.scores()), flush=True)


class _Colours:
    """The colours of a run's statics, and harmonics if wished."""

    def __init__(self, run: Path, truth: Path | None, harmonics: bool) -> None:
        folder = RunFolder(run)
        spec = folder.read_spec()
        self.capture = spec.open_capture()
        cameras = with_near_planes(self.capture.cameras, PointCloud.load(folder.points).xyz)
        self.cameras = [camera.scaled(0.5) for camera in cameras]
        self.held_out = [self.capture.camera_index(name) for name in spec.config.capture.hold_out]
        self.training = [index for index in range(len(cameras)) if index not in self.held_out]
        self.truth = Truth(self.capture, self.held_out, pictures=truth, masks=None, downscale=1)
        self.targets = Truth(self.capture, self.training, pictures=None, masks=None, downscale=1)
        self.scene = load_scene(folder.trained).map(torch.from_numpy)
        self.mapped = spec.config.train.colour_correction
        self.rgb = self.scene.static.rgb.clone().requires_grad_(True)
        self.harmonics = torch.zeros(len(self.rgb), 3, 3, requires_grad=True) if harmonics else None

    def train(self, steps: int) -> float:
        """Train and return the mean PSNR of the last fifth of the views."""
        parameters = [self.rgb] if self.harmonics is None else [self.rgb, self.harmonics]
        optimiser, random = torch.optim.Adam(parameters, lr=_RATE), np.random.default_rng(0)
        maps: dict[int, Tensor] = {}
        reached = []
        for step in range(steps):
            index, frame = int(random.choice(self.training)), int(random.integers(len(self.capture.times)))
            target, picture = _halved(self.targets.picture(index, frame)), self._drawn(index, frame)
            if self.mapped:
                fitting = _fitting_map(picture.detach(), target)
                maps[index] = torch.lerp(fitting, maps[index], _MEMORY) if index in maps else fitting
                picture = colour_affine(picture, maps[index])
            loss = photometric_loss(picture, target, 0.2)
            optimiser.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            for group in optimiser.param_groups:
                group["lr"] = _RATE * (1 - step / steps)
            optimiser.step()
            reached.append(_psnr(picture.detach(), target))
        return float(np.mean(reached[-steps // 5 :]))

    def scores(self) -> tuple[float, float]:
        """Return the mean PSNR of the held-out cameras, and after each picture's best colour map."""
        with torch.no_grad():
            pairs = list(self._shown())
        return float(np.mean([_psnr(p, t) for p, t in pairs])), float(
            np.mean([_psnr(colour_affine(p, _fitting_map(p, t)), t) for p, t in pairs])
        )

    def _shown(self) -> Iterator[tuple[Tensor, Tensor]]:
        for index in self.held_out:
            for frame in np.linspace(0, len(self.capture.times) - 1, _SCORED).astype(int):
                yield self._drawn(index, int(frame)).clamp(0, 1), _halved(self.truth.picture(index, int(frame)))

    def _drawn(self, index: int, frame: int) -> Tensor:
        camera, seconds, static = self.cameras[index], float(self.capture.times[frame]), self.scene.static
        segment, rgb = self.scene.segment_at(seconds), self.rgb
        if self.harmonics is not None:
            towards = torch.nn.functional.normalize(static.means - torch.tensor(camera.position).float(), dim=1)
            rgb = rgb + torch.einsum("nk,nkc->nc", towards, self.harmonics)
        return hgs.rasterize(
            dataclasses.replace(static, rgb=rgb),
            segment.dynamic,
            camera,
            segment.normalised(seconds),
            gradients="static",
            antialiased=self.scene.antialiased,
        ).rgb


def _halved(picture: Tensor) -> Tensor:
    """Return a picture [3, H, W] at half its size."""
    return torch.nn.functional.avg_pool2d(picture[None], 2)[0]


def _fitting_map(picture: Tensor, target: Tensor) -> Tensor:
    """Return the affine colour map [3, 4] that brings a picture [3, H, W] nearest to its target."""
    shown = torch.cat([picture.flatten(1), torch.ones(1, picture[0].numel())]).double()
    return torch.linalg.solve(shown @ shown.T, shown @ target.flatten(1).double().T).T.float()


def _psnr(picture: Tensor, target: Tensor) -> float:
    return float(-10 * torch.log10((picture - target).square().mean()))


if __name__ == "__main__":
    main()
