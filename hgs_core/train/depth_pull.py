"""The pull of given depth on splats that few cameras see (docs/numerics.md, "Loss")."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from hgs_core.points.given_surfaces import GivenSurfaces
from hgs_core.points.visibility import pixels_inside
from hgs_core.scene.camera import Camera

__all__ = ["DepthPull", "DepthTarget", "depth_loss"]

_BESIDE = 2  # pixels to each side in the median of depths
_LONGEST_SIDE = 640  # pixels of a kept map; it is looked up, not averaged


@dataclass(frozen=True)
class DepthTarget:
    """The given depth of a view."""

    inverse: Tensor  # [H, W] one over its depth along the axis, 1 where it is unknown
    weight: Tensor  # [H, W] 0 where it is unknown or something moves


class DepthPull:
    """The given depths of the still scene, for each training camera."""

    def __init__(self, surfaces: GivenSurfaces, cameras: Mapping[int, Camera]) -> None:
        self._surfaces, self._cameras = surfaces, cameras

    def target(
        self, place: int, camera: Camera, moving: npt.NDArray[np.bool_] | None, device: torch.device
    ) -> DepthTarget | None:
        """Return the depth of a view of the training camera at a place, drawn as `camera`; None where none is given.

        `moving` [h, w], of any size, are pixels of movers.
        """
        found = self._maps[place]
        if found is None:
            return None
        depths, weights = (_looked_up(one, camera) for one in found)
        if moving is not None:
            weights = np.where(_looked_up(moving, camera), np.float32(0), weights)
        inverse = 1 / np.where(weights > 0, depths, np.float32(1))
        return DepthTarget(torch.from_numpy(inverse).to(device), torch.from_numpy(weights).to(device))

    @cached_property
    def _maps(self) -> list[tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]] | None]:
        """The depths and weights [h, w] of each training camera."""
        views = list(self._cameras.values())
        sizes = [camera.scaled(min(1.0, _LONGEST_SIDE / max(camera.width, camera.height))) for camera in views]
        maps = [self._surfaces.still(index, size) for index, size in zip(self._cameras, sizes, strict=True)]
        return [
            None if one is None else (_smooth(one), _weights(one, size, [*views[:place], *views[place + 1 :]]))
            for place, (one, size) in enumerate(zip(maps, sizes, strict=True))
        ]


def depth_loss(drawn: Tensor, alpha: Tensor, target: DepthTarget) -> Tensor:
    """Return the weighted mean over pixels of |sum over splats of (blending weight) (z / depth - 1)|."""
    return (target.weight * (drawn * target.inverse - alpha).abs()).mean()


def _smooth(depths: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Return depths [h, w] with the median of the known ones among 25 in place of each: noise goes, edges stay."""
    known = np.where(depths > 0, depths, np.float32(np.inf))
    around = np.pad(known, _BESIDE, constant_values=np.inf)
    side = 2 * _BESIDE + 1
    shifted = [around[i : i + depths.shape[0], j : j + depths.shape[1]] for i in range(side) for j in range(side)]
    ordered = np.sort(np.stack(shifted), axis=0)  # unknown depths come last
    middle = np.maximum(np.isfinite(ordered).sum(0) - 1, 0)[None] // 2
    return np.where(depths > 0, np.take_along_axis(ordered, middle, 0)[0], np.float32(0))


def _weights(depths: npt.NDArray[np.float32], camera: Camera, others: Sequence[Camera]) -> npt.NDArray[np.float32]:
    """Return one over the number of cameras [h, w] that have a pixel's surface in their pictures; 0 without a depth."""
    row, column = np.nonzero(depths)
    xyz = camera.position + camera.rays(np.stack([column + 0.5, row + 0.5], 1)) * depths[row, column, None]
    seen = np.ones(len(xyz))
    for other in others:
        seen[pixels_inside(other, xyz)[0]] += 1
    weights = np.zeros_like(depths)
    weights[row, column] = 1 / seen
    return weights


def _looked_up(values: npt.NDArray[Any], camera: Camera) -> npt.NDArray[Any]:
    """Return the values [h, w] nearest to the pixels of a picture of the same shape."""
    height, width = values.shape
    rows = (np.arange(camera.height) + 0.5) * height / camera.height
    columns = (np.arange(camera.width) + 0.5) * width / camera.width
    return values[np.ix_(rows.astype(int), columns.astype(int))]
