"""How useful the dynamic splats of a trained run are, and which part of what moves is how wrong.

    .venv/bin/python -m scripts.experiments.useful_dynamics RUN

Printed are: how many dynamics the first segment has and how many live at a moment; which share of them has less than so
much of any training pixel; which share of them has 50, 90 and 99 % of all weight; the PSNR of moving training pixels
without the least useful ones, by three measures; and which share of the squared error the worst cells of 16x16 pixels
have, of those in which something moves. Of the frames every third is looked at, for PSNR and cells every sixth in every
third camera.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch

from hgs_core.decompose.masks import MotionMasks
from hgs_core.points.near_plane import with_near_planes
from hgs_core.points.point_cloud import PointCloud
from hgs_core.render.fixed_view import FixedView
from hgs_core.runs.run_folder import RunFolder
from hgs_core.scene.files import load_scene
from hgs_core.scene.temporal import evaluate

__all__ = ["held_by_the_best", "sums_of_cells"]

_CELL = 16
_PEAKS = (0.01, 0.02, 0.05, 0.1, 0.2)
_WEIGHTS = (0.5, 0.9, 0.99)
_LEFT_OUT = (0.1, 0.2, 0.3)
_WORST = (0.01, 0.05, 0.1, 0.25)

Doubles = npt.NDArray[np.float64]


def held_by_the_best(values: Doubles, share: float) -> float:
    """Return the share of the values [N], the greatest first, whose sum is so much of all."""
    sums = np.cumsum(np.sort(values)[::-1])
    return float(np.searchsorted(sums, share * sums[-1]) + 1) / len(values)


def sums_of_cells(picture: Doubles) -> Doubles:
    """Return the sums [ceil(H/16), ceil(W/16)] over the cells of a picture [H, W]."""
    height, width = picture.shape
    padded = np.pad(picture, ((0, -height % _CELL), (0, -width % _CELL)))
    return np.asarray(padded.reshape(padded.shape[0] // _CELL, _CELL, -1, _CELL).sum((1, 3)))


class _Run:
    """The first segment of a trained run."""

    def __init__(self, path: Path) -> None:
        folder = RunFolder(path)
        spec = folder.read_spec()
        self.capture = spec.open_capture()
        self.cameras = with_near_planes(self.capture.cameras, PointCloud.load(folder.points).xyz)
        self.trained = spec.config.capture.training_cameras(self.capture)
        self.masks = MotionMasks.load(folder.masks, self.capture)
        self.scene = load_scene(folder.trained).map(torch.from_numpy)
        self.segment = self.scene.segments[0]
        self.frames = [
            frame for frame in range(1, len(self.capture.times), 3) if self.capture.times[frame] <= self.segment.end
        ]

    def moment(self, frame: int) -> float:
        return float(self.segment.normalised(float(self.capture.times[frame])))

    def view(self, camera: int) -> FixedView:
        return FixedView(self.scene.static, self.cameras[camera], antialiased=self.scene.antialiased)

    def weights(self) -> tuple[Doubles, Doubles]:
        """Return the greatest and the mean blending weight of every dynamic splat, over all pictures looked at."""
        still, count = len(self.scene.static), len(self.segment.dynamic)
        peak, total = np.zeros(count), np.zeros(count)
        for camera in self.trained:
            view = self.view(camera)
            for frame in self.frames:
                found = view.contributions(self.segment.dynamic, self.moment(frame))
                peak = np.maximum(peak, found.peak[still:])
                total += found.total[still:]
        return peak, total / (len(self.trained) * len(self.frames))

    def errors(self, keep: npt.NDArray[np.bool_]) -> tuple[float, Doubles]:
        """Return the PSNR of moving pixels with the dynamics that are kept, and the squared errors of their cells."""
        dynamic = self.segment.dynamic.take(torch.from_numpy(np.flatnonzero(keep)))
        cells: list[Doubles] = []
        error = pixels = 0.0
        for camera in self.trained[::3]:
            view = self.view(camera)
            for frame in self.frames[::2]:
                drawn = view.frame(dynamic, self.moment(frame)).rgb.clamp(0, 1).permute(1, 2, 0).double().numpy()
                moving = self.masks.mask(camera, frame)
                wrong = ((drawn - self.capture.frame(camera, frame) / 255) ** 2).mean(2) * moving
                cells.append(sums_of_cells(wrong)[sums_of_cells(moving.astype(np.float64)) > 0])
                error, pixels = error + wrong.sum(), pixels + moving.sum()
        return -10 * float(np.log10(error / pixels)), np.concatenate(cells)


def _row(values: list[float]) -> str:
    return ", ".join(f"{value:.3f}" for value in values)


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("run", type=Path)
    run = _Run(parser.parse_args().run)
    dynamic = run.segment.dynamic.map(lambda array: array.numpy())
    alive = [int((evaluate(dynamic, moment)[2] > 0.02).sum()) for moment in np.linspace(0, 1, 21)]
    print(f"{len(dynamic)} dynamics, {np.mean(alive):.0f} alive; {run.masks.share():.2%} of the pixels move")
    peak, total = run.weights()
    print(f"greatest weight below {_PEAKS}: {_row([float((peak < value).mean()) for value in _PEAKS])} of them")
    print(f"{_WEIGHTS} of all weight: {_row([held_by_the_best(total, share) for share in _WEIGHTS])} of them")
    axes = np.sort(np.exp(dynamic.log_scales.astype(np.float64)), axis=1)
    life = np.minimum(1, np.sqrt(np.pi / np.exp(dynamic.time_log_precisions.astype(np.float64))))
    guessed = axes[:, 1] * axes[:, 2] * life / (1 + np.exp(-dynamic.opacity_logits.astype(np.float64)))
    everything, cells = run.errors(np.ones(len(dynamic), np.bool_))
    print(f"moving training pixels: {everything:.3f} dB; without the least {_LEFT_OUT} by")
    for name, use in (("mean weight", total), ("greatest weight", peak), ("opacity x area x life", guessed)):
        ranks = np.argsort(np.argsort(use, kind="stable"), kind="stable") / len(use)
        print(f"  {name}: {_row([run.errors(ranks >= share)[0] for share in _LEFT_OUT])}")
    worst = np.sort(cells)[::-1]
    held = [worst[: round(share * len(worst))].sum() / worst.sum() for share in _WORST]
    print(f"the worst {_WORST} of the cells have {_row(held)} of the squared error")


if __name__ == "__main__":
    main()
