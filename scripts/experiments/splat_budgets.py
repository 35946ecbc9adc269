"""What a picture loses where the viewer draws a part of the splats alone.

    .venv/bin/python -m scripts.experiments.splat_budgets RUN [--moves OCTAVES]

Of the splats that are alive at three moments of the first segment, parts are taken by the rule of the viewer's budget
(docs/viewer.md, "Fewer splats"), which is written down here once more, and drawn from four of the capture's cameras.
Printed are decibels against the picture of all splats: of the whole picture, of where it would change by more than 0.1
without the splats that move, and the same for as many splats taken at random. `--moves` is by how many octaves of
utility what moves is preferred; 2 in the viewer.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch

from hgs_core.codec import DecodedChunk, decode_scene, load_manifest, read_chunk
from hgs_core.render import rasterize
from hgs_core.runs.run_folder import RunFolder
from hgs_core.scene import HybridScene
from hgs_core.scene.camera import Camera

__all__ = ["taken", "utility"]

_MOVES = 2.0  # octaves
_SHARES = (0.75, 0.5, 0.25)
_TIMES = (0.1, 0.45, 0.8)  # normalised
_CAMERAS = 4
_GOLDEN = 0.6180339887498949

Doubles = npt.NDArray[np.float64]
Marks = npt.NDArray[np.bool_]


def utility(chunk: DecodedChunk, time: float, moves: float = _MOVES) -> Doubles:
    """Return how useful each splat [N] of a chunk is at a normalised time, octaves; minus infinity for a dead one."""
    mean = np.full(chunk.count, -2 * np.log2(chunk.bounds.rgb), np.float64)
    if "time_centers" not in chunk.arrays:
        return mean
    opacity, center, log_precision = (
        chunk.arrays[name].astype(np.float64) for name in ("opacities", "time_centers", "time_log_precisions")
    )
    fading = np.exp(log_precision) * (time - center) ** 2
    shown = np.minimum(1, np.sqrt(np.pi / (2 * np.exp(log_precision))))  # of the segment
    now = mean + moves - np.log2(shown) - 2 * np.log2(np.e) * fading
    return np.where(opacity * np.exp(-fading) >= 1 / 255, now, -np.inf)


def taken(chunks: Sequence[Doubles], budget: int) -> Marks:
    """Return which splats, of all chunks in a row, a budget has room for, given how useful those of each are."""
    level = np.concatenate([np.round(4 * chunk) for chunk in chunks])
    spread = np.concatenate([np.arange(len(chunk)) * _GOLDEN % 1 for chunk in chunks])
    keep = np.zeros(len(level), bool)
    keep[np.lexsort((-spread, -level))[:budget]] = True
    return keep & (level > -np.inf)


def _picture(scene: HybridScene[npt.NDArray[np.float32]], keep: Marks, camera: Camera, time: float) -> Doubles:
    """Draw the splats that are marked, of the statics and then the first segment's dynamics; [3, H, W]."""
    still = len(scene.static)
    render = rasterize(
        scene.static.take(keep[:still]).map(torch.from_numpy),
        scene.segments[0].dynamic.take(keep[still:]).map(torch.from_numpy),
        camera,
        time,
        background=scene.background,
        antialiased=scene.antialiased,
        gradients="none",
    )
    return np.clip(render.rgb.double().numpy(), 0, 1)


def _losses(run: Path, share: float, moves: float) -> Doubles:
    """Return mean squared errors [views, 4]: whole and where it moves, by the rule; the same at random."""
    folder = RunFolder(run).scene
    manifest, scene = load_manifest(folder), decode_scene(folder)
    entries = [*manifest.static, *(entry for part in manifest.slices if part.segment == 0 for entry in part.chunks)]
    chunks = [read_chunk(folder, entry) for entry in entries]
    r = np.random.default_rng(0)
    rows = []
    for time in _TIMES:
        useful = [utility(chunk, time, moves) for chunk in chunks]
        alive = np.concatenate(useful) > -np.inf
        budget = int(share * alive.sum())
        kept = taken(useful, budget)
        random = np.zeros(len(alive), bool)
        random[r.permutation(np.flatnonzero(alive))[:budget]] = True
        still = alive & (np.arange(len(alive)) < len(scene.static))
        for camera in manifest.cameras[:: max(1, len(manifest.cameras) // _CAMERAS)][:_CAMERAS]:
            truth = _picture(scene, alive, camera, time)
            moving = np.abs(truth - _picture(scene, still, camera, time)).max(axis=0) > 0.1
            errors = [(_picture(scene, keep, camera, time) - truth) ** 2 for keep in (kept, random)]
            rows.append([float(error[:, where].mean()) for error in errors for where in (moving | True, moving)])
    return np.asarray(rows)


def main() -> None:
    """Print a line for each share of the splats."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path)
    parser.add_argument("--moves", type=float, default=_MOVES)
    options = parser.parse_args()
    for share in _SHARES:
        whole, moving, any_whole, any_moving = -10 * np.log10(_losses(options.run, share, options.moves).mean(axis=0))
        print(
            f"{share:.0%} of the splats: {whole:.1f} dB, where it moves {moving:.1f} dB;"
            f" any {share:.0%}: {any_whole:.1f} and {any_moving:.1f} dB"
        )


if __name__ == "__main__":
    main()
