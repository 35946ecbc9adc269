"""The costs of a coarse plane sweep: colours at two scales, between a picture's rays and its neighbours' pixels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from hgs_core.decompose.morphology import box_sum
from hgs_core.native import colour_sweep as native
from hgs_core.native.library import available
from hgs_core.points.colour_difference import colour_difference
from hgs_core.points.point_labels import label_points
from hgs_core.points.visibility import pixels_inside
from hgs_core.scene.camera import Camera

__all__ = ["BLIND_COST", "HULL_SHARE", "colour_descriptors", "sweep_costs"]

BLIND_COST = 60.0
"""Cost, levels of 255, of a neighbour that does not see a point."""

HULL_SHARE = 0.75
"""Share of the views that must see a point move: nearly all, as some may be blocked."""


def colour_descriptors(picture: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Return the descriptors of a picture's pixels [H, W, 3], [H W, 6]: colour at their own scale and around.

    These are the means over 3x3 and 7x7 pixels, rounded down; what lies outside of the picture is black.
    """
    if available():
        return native.colour_descriptors(np.ascontiguousarray(picture))
    wide = picture.astype(np.int16)
    return np.concatenate((box_sum(wide, 1) // 9, box_sum(wide, 3) // 49), axis=2).astype(np.uint8).reshape(-1, 6)


def sweep_costs(
    camera: Camera,
    rays: npt.NDArray[np.float64],  # [R, 3] from the camera to depth 1
    own: npt.NDArray[np.uint8],  # [R, 6] descriptors of their pixels
    depths: npt.NDArray[np.float64],  # [D]
    neighbours: Sequence[tuple[Camera, npt.NDArray[np.uint8]]],  # other cameras and descriptors [H W, 6]
    hull: Sequence[tuple[Camera, npt.NDArray[np.bool_]]],  # cameras, and masks [H, W] of what moves; none: everywhere
) -> npt.NDArray[np.float32]:
    """Return the costs [R, D] of points along rays: mean differences of descriptors, levels of 255.

    The neighbour that fits worst, which may be blocked, does not count. Points outside of the hull cost infinity.
    """
    if available():
        return native.colour_sweep(
            camera.position,
            np.ascontiguousarray(rays),
            np.ascontiguousarray(own),
            depths,
            neighbours,
            hull,
            hull_share=HULL_SHARE,
            blind=BLIND_COST,
        )
    points = (camera.position + rays[:, None] * depths[:, None]).reshape(-1, 3)
    ray = np.repeat(np.arange(len(rays)), len(depths))
    costs = np.full((len(neighbours), len(points)), BLIND_COST, np.float32)
    for cost, (other, descriptors) in zip(costs, neighbours, strict=True):
        rows, pixels = pixels_inside(other, points)
        cost[rows] = colour_difference(
            descriptors[pixels[:, 1] * other.width + pixels[:, 0]].astype(np.int16), own[ray[rows]].astype(np.int16)
        )
    costs.sort(axis=0)
    cost = costs[: max(1, len(neighbours) - 1)].mean(axis=0)
    if hull:
        cameras, masks = zip(*hull, strict=True)
        cost[label_points(cameras, masks, points) < HULL_SHARE] = np.inf
    return np.asarray(cost.reshape(len(rays), len(depths)), np.float32)
