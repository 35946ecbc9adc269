"""Points in space that explain wrong pixels of a scene, for the splats of births and infill.

The worst pixels are swept, as initialisation does for whole moments.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from torch import Tensor

from hgs_core.decompose.morphology import box_sum
from hgs_core.points.point_cloud import PointCloud
from hgs_core.points.point_labels import label_points, mean_over_views
from hgs_core.points.sweep import sweep
from hgs_core.scene.camera import Camera

__all__ = ["MissingPoints", "chosen_points", "find_missing_points", "picture_error"]

_WRONG_LEVELS = 20  # levels of 255 that count as wrong
_RAY_STEP = 2  # pixels between swept rays: what is missing is often small
_SIZE_SHARE = 0.7  # standard deviation of a new splat, in distances between rays at the mean view
_WRONG_SHARE = 0.5  # share of the views whose pixel there must be wrong
_CONFIRMING_VIEWS = 2  # other views whose depth must agree: rather too few, a wrong splat is in the way of the view


@dataclass(frozen=True)
class MissingPoints:
    """Points that the scene lacks at one moment."""

    points: PointCloud
    urgency: npt.NDArray[np.float64]  # [P] the square of how wrong the pictures are there, levels of 255


def picture_error(picture: Tensor, truth: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
    """Return [H, W] the mean error of the channels over 3x3 pixels, in levels of 255.

    The picture is [3, H, W] in [0, 1], its truth [H, W, 3].
    """
    levels = (picture.clamp(0, 1) * 255).numpy().astype(np.int16)
    red, green, blue = np.abs(levels - np.moveaxis(truth, 2, 0))
    return box_sum((red + green + blue) // 3, 1).astype(np.float32) / np.float32(9)


def find_missing_points(
    cameras: Sequence[Camera],
    pictures: Sequence[npt.NDArray[np.uint8]],  # [H, W, 3] of one moment
    asked: Sequence[npt.NDArray[np.bool_]],  # [H, W] what moves in them, or what stands still
    errors: Sequence[npt.NDArray[np.float32]],  # [H, W] how wrong the scene is there, levels of 255
    ranges: Sequence[tuple[float, float]],  # nearest and farthest depth of each camera
    *,
    hull: bool = True,
    pixels: int = 600,
) -> MissingPoints:
    """Return points that explain wrong pixels among those that are asked for, at time 0.

    A point must be confirmed by two other views' depths and be wrong in half of the views it falls in: what is right in
    most views is there already. With `hull` it must also lie in the hull of the pixels that are asked for. Of every
    picture at most `pixels` are swept.
    """
    wanted = [_worst(error, one & (error > _WRONG_LEVELS), pixels) for error, one in zip(errors, asked, strict=True)]
    area = sum(int(mask.sum()) for mask in wanted)
    if area == 0:
        return MissingPoints(PointCloud.concatenate([]), np.zeros(0))

    swept = sweep(cameras, pictures, wanted, ranges, area // _RAY_STEP**2, asked if hull else ())
    chosen = np.flatnonzero((swept.agreeing >= _CONFIRMING_VIEWS) & (swept.opposed <= swept.agreeing))
    wrong = [error > _WRONG_LEVELS for error in errors]  # not before: sweeps of many large pictures fill the memory
    chosen = chosen[label_points(cameras, wrong, swept.xyz[chosen]) >= _WRONG_SHARE]
    xyz = swept.xyz[chosen]
    none = np.zeros(len(xyz), np.float32)
    points = PointCloud.at_rest(xyz, swept.rgb[chosen], none, none, _sizes(cameras, xyz))
    return MissingPoints(points, mean_over_views(cameras, errors, xyz).astype(np.float64) ** 2)


def chosen_points(missing: Sequence[MissingPoints], most: int, generator: np.random.Generator) -> PointCloud:
    """Return at most `most` points of all moments, drawn in proportion to their urgency.

    Not so many of each moment: where something appears or vanishes at once, the splats of one side alone have to show
    it, and much more is missing than between moments that resemble each other.
    """
    points = PointCloud.concatenate([found.points for found in missing])
    if len(points) <= most:
        return points
    urgency = np.concatenate([found.urgency for found in missing])
    return points.take(np.sort(generator.choice(len(points), max(0, most), replace=False, p=urgency / urgency.sum())))


def _worst(error: npt.NDArray[np.float32], pixels: npt.NDArray[np.bool_], most: int) -> npt.NDArray[np.bool_]:
    """Return the worst of the given pixels [H, W]: sweeping is slow, and the rest can be reached from there."""
    if int(pixels.sum()) <= most:
        return pixels
    border = np.partition(error[pixels], -most)[-most]
    return np.asarray(pixels & (error >= border))


def _sizes(cameras: Sequence[Camera], xyz: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Return the standard deviations [P] that are fitting at the mean distance from the cameras that face a point."""
    if len(xyz) == 0:
        return np.zeros(0, np.float32)
    depths = [(camera, camera.project(xyz)[1]) for camera in cameras]
    pixels = np.stack([np.where(z > camera.near, z, np.nan) / camera.fx for camera, z in depths])
    return np.asarray(_SIZE_SHARE * _RAY_STEP * np.nanmean(pixels, axis=0), np.float32)
