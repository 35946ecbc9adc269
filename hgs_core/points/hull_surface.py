"""The surface of the visual hull: the nearest places along the rays of moving pixels that no view denies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base.arrays import Doubles
from hgs_core.decompose.morphology import dilate
from hgs_core.points.depth_map import GivenDepth, no_depth
from hgs_core.points.far_apart import level, vertical_of
from hgs_core.points.visibility import pixels_inside
from hgs_core.scene.camera import Camera

__all__ = ["PROOF", "HullSurface", "grid_rays", "grid_step", "hull_surface", "soft_masks", "views_of_movers"]

PROOF = 2
"""Views that must show a mover for its place to be known."""

_STEPS = 160  # tried depths of a ray
_AT_ONCE = 512  # rays
_HALVINGS = 5  # halvings of a step at the surface
_LIKE = 0.5  # share of a picture's height within which a pixel has its depth from another of the same mask
_SOFT = 0.003  # share of a picture's width by which masks may be wrong


@dataclass(frozen=True)
class HullSurface:
    """Places on the hull's surface."""

    xyz: npt.NDArray[np.float32]  # [P, 3]
    rgb: npt.NDArray[np.float32]  # [P, 3] colours of the pixels whose rays meet them, 0..1
    spacing: npt.NDArray[np.float32]  # [P] distances between the rays there
    towards: npt.NDArray[np.float32]  # [P, 3] directions to the cameras of these pixels


def soft_masks(masks: Sequence[npt.NDArray[np.bool_]]) -> list[npt.NDArray[np.bool_]]:
    """Return masks [H, W] grown by as much as they may be wrong."""
    return [dilate(mask, max(1, round(_SOFT * mask.shape[1]))) for mask in masks]


def views_of_movers(
    cameras: Sequence[Camera],
    masks: Sequence[npt.NDArray[np.bool_]],  # [H, W] each
    xyz: npt.NDArray[np.floating[Any]],  # [P, 3]
) -> npt.NDArray[np.int64]:
    """Return [P] how many views show that something moves at each place; 0 where one shows that nothing does."""
    denied, views = np.zeros(len(xyz), np.bool_), np.zeros(len(xyz), np.int64)
    for camera, mask in zip(cameras, masks, strict=True):
        rows, pixels = pixels_inside(camera, xyz)
        views[rows] += 1
        denied[rows] |= ~mask[pixels[:, 1], pixels[:, 0]]
    return np.where(denied, 0, views)


def grid_step(masks: Sequence[npt.NDArray[np.bool_]], rays: int) -> int:
    """Return the distance in pixels of a grid that has at least so many pixels of masks [H, W], if they are so many."""
    area = sum(int(mask.sum()) for mask in masks)
    return max(1, int(np.sqrt(area / max(rays, 1))))


def grid_rays(
    camera: Camera, mask: npt.NDArray[np.bool_], step: int
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], Doubles]:
    """Return the rows and columns [R] of a grid's pixels in a mask [H, W], and their rays [R, 3] to depth 1."""
    rows, columns = (step * place + step // 2 for place in np.nonzero(mask[step // 2 :: step, step // 2 :: step]))
    return rows, columns, camera.rays(np.stack([columns + 0.5, rows + 0.5], 1).astype(np.float64))


def hull_surface(
    cameras: Sequence[Camera],
    pictures: Sequence[npt.NDArray[np.uint8]],  # [H, W, 3] each
    moving: Sequence[npt.NDArray[np.bool_]],  # [H, W] each
    rays: int,  # how many of them at least, if there are so many, over all pictures
    known: GivenDepth = no_depth,
) -> HullSurface:
    """Return where the rays of a grid of moving pixels enter the hull, at its thickest part along each.

    Where people hide each other the hull has parts where nobody is; they are thinner than people. What one picture
    alone shows, such as feet that stand below all others, is as far away on the floor as the nearest of its pixels
    whose place is known. Known depths that no view denies come before all that.
    """
    grown = soft_masks(moving)
    step = grid_step(moving, rays)
    positions = np.array([camera.position for camera in cameras])
    vertical = vertical_of(cameras)
    found: list[tuple[Doubles, Doubles, Doubles, Doubles]] = []
    for view, (camera, picture, mask) in enumerate(zip(cameras, pictures, moving, strict=True)):
        rows, columns, directions = grid_rays(camera, mask, step)
        far = float(np.linalg.norm(positions - camera.position, axis=1).max())
        depths, inside = _entries(cameras, grown, camera, directions, far)
        given = known(view, camera)
        if given is not None:
            own = given[rows, columns].astype(np.float64)
            fits = (own > 0) & (views_of_movers(cameras, grown, camera.position + directions * own[:, None]) > 0)
            depths, inside = np.where(fits, own, depths), inside | fits
        depths, inside = _continued(depths, inside, rows, columns, directions, vertical, _LIKE * camera.height)
        rows, columns, directions, depths = rows[inside], columns[inside], directions[inside], depths[inside]
        found.append(
            (
                camera.position + directions * depths[:, None],
                picture[rows, columns] / 255.0,
                step * depths / camera.fx,
                -directions / np.linalg.norm(directions, axis=1)[:, None],
            )
        )
    return HullSurface(*(np.concatenate(parts).astype(np.float32) for parts in zip(*found, strict=True)))


def _entries(
    cameras: Sequence[Camera],
    masks: Sequence[npt.NDArray[np.bool_]],
    camera: Camera,
    directions: Doubles,  # [R, 3] to depth 1
    far: float,
) -> tuple[Doubles, npt.NDArray[np.bool_]]:
    """Return the depths [R] at which rays enter the hull, and which of them do."""
    step = far / _STEPS

    def inside(depths: Doubles) -> npt.NDArray[np.bool_]:  # [R, D]
        places = camera.position + directions[:, None] * depths[:, :, None]
        return views_of_movers(cameras, masks, places.reshape(-1, 3)).reshape(depths.shape) >= PROOF

    tried = np.broadcast_to(step * np.arange(1, _STEPS + 1), (len(directions), _STEPS))
    first, thickness = _longest_run(inside(tried))
    within = step * (first + 1.0)
    without = within - step
    for _ in range(_HALVINGS):
        middle = (within + without) / 2
        hit = inside(middle[:, None])[:, 0]
        within, without = np.where(hit, middle, within), np.where(hit, without, middle)
    return np.asarray(within), np.asarray(thickness > 0)


def _continued(
    depths: Doubles,  # [R]
    inside: npt.NDArray[np.bool_],  # [R] rays whose depth is known
    rows: npt.NDArray[np.int64],
    columns: npt.NDArray[np.int64],
    directions: Doubles,  # [R, 3] to depth 1
    vertical: Doubles,
    reach: float,  # pixels
) -> tuple[Doubles, npt.NDArray[np.bool_]]:
    """Return depths, and which are known, with those of rays that are as far away horizontally as the nearest known."""
    known, unknown = np.flatnonzero(inside), np.flatnonzero(~inside)
    if len(known) == 0 or len(unknown) == 0:
        return depths, inside
    across = np.linalg.norm(level(directions, vertical), axis=1)
    depths, inside = depths.copy(), inside.copy()
    for first in range(0, len(unknown), _AT_ONCE):
        part = unknown[first : first + _AT_ONCE]
        apart = (rows[part][:, None] - rows[known]) ** 2 + (columns[part][:, None] - columns[known]) ** 2
        nearest = apart.argmin(1)
        like = known[nearest]
        depths[part] = depths[like] * across[like] / np.maximum(across[part], 1e-9)
        inside[part] = apart[np.arange(len(part)), nearest] <= reach**2
    return depths, inside


def _longest_run(marked: npt.NDArray[np.bool_]) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return where the first longest run of each row of [R, D] starts, and its length, 0 for none."""
    best, longest, run = (np.zeros(len(marked), np.int64) for _ in range(3))
    for place, column in enumerate(marked.T):
        run = np.where(column, run + 1, 0)
        longer = run > longest
        longest, best = np.where(longer, run, longest), np.where(longer, place - run + 1, best)
    return best, longest
