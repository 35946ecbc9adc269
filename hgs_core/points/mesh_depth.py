"""Depths of a mesh in a picture: the nearest triangle behind the centre of every pixel."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hgs_core.base.arrays import Doubles
from hgs_core.scene.camera import Camera

__all__ = ["mesh_depth"]

_NEAR = 1e-3  # world units, as in `pixels_inside`
_TRIANGLES_AT_ONCE = 1 << 18
_AT_ONCE = 1 << 22  # pixels that are tried


def mesh_depth(corners: Doubles, camera: Camera, nearest: float = 0.0) -> npt.NDArray[np.float32]:
    """Return the depths [H, W] along the axis of triangles [T, 3, 3] in a camera's picture; 0 where none is.

    Triangles are seen from both sides. What lies nearer than `nearest` is cut off: scans close the holes in walls
    through which cameras look, and show their housings.
    """
    depths = np.full(camera.width * camera.height, np.inf)
    for begin in range(0, len(corners), _TRIANGLES_AT_ONCE):
        _draw(depths, corners[begin : begin + _TRIANGLES_AT_ONCE], camera, max(nearest, _NEAR))
    return np.where(np.isinf(depths), 0, depths).astype(np.float32).reshape(camera.height, camera.width)


def _draw(nearest: Doubles, corners: Doubles, camera: Camera, plane: float) -> None:
    """Lower the nearest depths [H W] to those of triangles [T, 3, 3] behind a plane."""
    turn, move = camera.world_to_camera[:3, :3], camera.world_to_camera[:3, 3]
    local = _behind(corners @ turn.T + move, plane)
    depths = local[:, :, 2]
    across = local[:, :, 0] / depths * camera.fx + camera.cx
    down = local[:, :, 1] / depths * camera.fy + camera.cy
    first, width = _pixels(across, camera.width)
    top, height = _pixels(down, camera.height)
    area = _turned(across[:, 0], down[:, 0], across[:, 1], down[:, 1], across[:, 2], down[:, 2])
    drawn = np.flatnonzero((width > 0) & (height > 0) & (area != 0))
    counts = (width * height)[drawn]
    chunk = np.cumsum(counts) // _AT_ONCE  # chunk numbers of triangles
    for number in np.unique(chunk):
        rows, own = drawn[chunk == number], counts[chunk == number]
        triangle = np.repeat(rows, own)
        place = np.arange(len(triangle)) - np.repeat(np.cumsum(own) - own, own)
        column, row = first[triangle] + place % width[triangle], top[triangle] + place // width[triangle]
        x, y = column + 0.5, row + 0.5
        inverse = np.zeros(len(triangle))
        inside = np.ones(len(triangle), bool)
        for corner, (a, b) in enumerate(((1, 2), (2, 0), (0, 1))):
            ends = across[triangle, a], down[triangle, a], across[triangle, b], down[triangle, b]
            share = _turned(x, y, *ends) / area[triangle]
            inside &= share >= 0
            inverse += share / depths[triangle, corner]  # linear in the picture
        pixels = row * camera.width + column
        np.minimum.at(nearest, pixels[inside], 1 / inverse[inside])


def _behind(local: Doubles, plane: float) -> Doubles:
    """Return the triangles [T, 3, 3] in a camera's coordinates without the parts that are nearer than a plane."""
    front = local[:, :, 2] > plane
    count = front.sum(1)
    one = _turned_to(local, front.argmax(1), count == 1)
    two = _turned_to(local, front.argmin(1), count == 2)  # the corner behind comes first
    to_second, to_third = _cut(one[:, 0], one[:, 1], plane), _cut(one[:, 0], one[:, 2], plane)
    from_second, from_third = _cut(two[:, 1], two[:, 0], plane), _cut(two[:, 2], two[:, 0], plane)
    parts = [
        local[count == 3],
        np.stack([one[:, 0], to_second, to_third], 1),
        np.stack([two[:, 1], two[:, 2], from_second], 1),
        np.stack([two[:, 2], from_third, from_second], 1),
    ]
    return np.concatenate(parts)


def _turned_to(local: Doubles, first: npt.NDArray[np.int64], chosen: npt.NDArray[np.bool_]) -> Doubles:
    """Return the chosen triangles with other first corners."""
    order = (first[chosen, None] + np.arange(3)) % 3
    return np.take_along_axis(local[chosen], order[:, :, None], 1)


def _cut(far: Doubles, near: Doubles, plane: float) -> Doubles:
    """Return the places [N, 3] in a plane on lines from points behind it to points before it."""
    share = (far[:, 2] - plane) / (far[:, 2] - near[:, 2])
    return np.asarray(far + share[:, None] * (near - far))


def _pixels(places: Doubles, size: int) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the first pixel, and the number of pixels, with their centres between places [T, 3] and in the picture."""
    first = np.ceil(places.min(1) - 0.5).clip(0, size).astype(np.int64)
    last = np.floor(places.max(1) - 0.5).clip(-1, size - 1).astype(np.int64)
    return first, np.maximum(last - first + 1, 0)


def _turned(x: Doubles, y: Doubles, ax: Doubles, ay: Doubles, bx: Doubles, by: Doubles) -> Doubles:
    """Return twice the signed areas [N] of triangles of which the first corner is (x, y)."""
    return np.asarray((ax - x) * (by - y) - (ay - y) * (bx - x))
