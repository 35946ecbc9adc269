"""How many static splats of a run have another one that is nearly the same.

    .venv/bin/python -m scripts.experiments.near_duplicates RUN

Of the eight nearest neighbours one counts if the Bhattacharyya distance of the two Gaussians is below 0.1 and no colour
channel differs by 0.1 or more.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import torch
from torch import Tensor

import hgs_core as hgs

__all__ = ["has_duplicate"]

_NEIGHBOURS = 8
_DISTANCE = 0.1
_COLOUR = 0.1
_BLOCK = 1000  # splats compared with all others at once


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path)
    static = hgs.load_scene(parser.parse_args().run / "scene.npz").map(torch.from_numpy).static
    found = int(has_duplicate(static).sum())
    print(f"{found} of {len(static)} static splats ({found / len(static):.1%}) have a near-duplicate")


def has_duplicate(static: hgs.StaticSplats[Tensor]) -> Tensor:
    """Return [N] whether a splat has a near-duplicate."""
    means, covariances = static.means.double(), _covariances(static)
    neighbours = []
    for block in means.split(_BLOCK):
        nearest = torch.cdist(block, means).topk(min(_NEIGHBOURS + 1, len(means)), largest=False).indices
        neighbours.append(nearest)
    others = torch.cat(neighbours)  # [N, K], one of which is the splat itself
    itself = others == torch.arange(len(means))[:, None]
    offset = (means[others] - means[:, None])[..., None]  # [N, K, 3, 1]
    mean_covariance = (covariances[others] + covariances[:, None]) / 2
    apart = (offset.mT @ torch.linalg.solve(mean_covariance, offset)).squeeze((-1, -2)) / 8
    volumes = static.log_scales.double().sum(dim=1)  # half the logarithms of the determinants
    unlike = torch.logdet(mean_covariance) / 2 - (volumes[others] + volumes[:, None]) / 2
    colours = (static.rgb[others] - static.rgb[:, None]).abs().amax(dim=2)
    return ((apart + unlike < _DISTANCE) & (colours < _COLOUR) & ~itself).any(dim=1)


def _covariances(static: hgs.StaticSplats[Tensor]) -> Tensor:
    """Return [N, 3, 3], float64."""
    w, x, y, z = torch.nn.functional.normalize(static.quats.double(), dim=1).unbind(1)
    rows = [
        1 - 2 * (y * y + z * z),
        2 * (x * y - w * z),
        2 * (x * z + w * y),
        2 * (x * y + w * z),
        1 - 2 * (x * x + z * z),
        2 * (y * z - w * x),
        2 * (x * z - w * y),
        2 * (y * z + w * x),
        1 - 2 * (x * x + y * y),
    ]
    axes = torch.stack(rows, dim=1).reshape(-1, 3, 3) * static.log_scales.double().exp()[:, None]
    return axes @ axes.mT


if __name__ == "__main__":
    main()
