"""Lens distortion: the polynomial model of OpenCV and COLMAP, and pictures freed from it.

A ray (x, y, 1) of the camera meets the sensor at

    x' = x d + 2 p1 x y + p2 (r^2 + 2 x^2),   y' = y d + p1 (r^2 + 2 y^2) + 2 p2 x y,
    d = 1 + k1 r^2 + k2 r^4 + k3 r^6 + k4 r^8,   r^2 = x^2 + y^2

(Brown 1971; the tangential terms as OpenCV numbers them).
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.scene.camera import Camera

__all__ = ["Distortion", "straight_camera", "straightened"]

_STRIP_ROWS = 128  # rows at a time, so that resampling needs little memory
_INVERSION_STEPS = 50  # of the inversion; it gains a digit or more per step
_EDGE_SAMPLES = 65  # points on each side of the picture

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Distortion:
    """The coefficients of one lens."""

    k1: float = 0.0
    k2: float = 0.0
    k3: float = 0.0
    k4: float = 0.0
    p1: float = 0.0
    p2: float = 0.0

    @property
    def is_none(self) -> bool:
        """Whether the lens is a pinhole."""
        return not any(dataclasses.astuple(self))

    def apply(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Return where the rays (x, y, 1) meet the sensor, in units of the focal length."""
        r2 = x * x + y * y
        radial = 1 + r2 * (self.k1 + r2 * (self.k2 + r2 * (self.k3 + r2 * self.k4)))
        return (
            x * radial + 2 * self.p1 * x * y + self.p2 * (r2 + 2 * x * x),
            y * radial + self.p1 * (r2 + 2 * y * y) + 2 * self.p2 * x * y,
        )

    def remove(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Return the rays that meet the sensor at (x, y): the inverse of `apply`, by fixed-point iteration.

        Where the model cannot be inverted the result is what the iteration came to.
        """
        straight_x, straight_y = x.copy(), y.copy()
        for _ in range(_INVERSION_STEPS):
            reached_x, reached_y = self.apply(straight_x, straight_y)
            straight_x, straight_y = straight_x + (x - reached_x), straight_y + (y - reached_y)
        return straight_x, straight_y


def straight_camera(camera: Camera, lens: Distortion) -> Camera:
    """Return the pinhole camera of the straightened picture.

    Focal lengths stay, so that the middle keeps its sharpness, and the picture becomes the largest rectangle that the
    photograph covers: no pixel of it lies outside the photograph, and what bends over its edges is cut off.

    Raises:
        InputError: the coefficients fold the picture over itself.
    """
    if lens.is_none:
        return camera
    span_x = np.linspace(0.5, camera.width - 0.5, _EDGE_SAMPLES)
    span_y = np.linspace(0.5, camera.height - 0.5, _EDGE_SAMPLES)

    def rays(u: Floats, v: Floats) -> tuple[Floats, Floats]:
        x, y = (u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy
        with np.errstate(over="ignore", invalid="ignore"):
            straight = lens.remove(x, y)
            back = lens.apply(*straight)
            miss = np.hypot((back[0] - x) * camera.fx, (back[1] - y) * camera.fy)
        if not (miss < 0.01).all():
            raise InputError(
                f"camera {camera.name}", "its distortion coefficients fold the picture", "calibrate it again"
            )
        return straight

    left = float(rays(np.full(_EDGE_SAMPLES, span_x[0]), span_y)[0].max())
    right = float(rays(np.full(_EDGE_SAMPLES, span_x[-1]), span_y)[0].min())
    top = float(rays(span_x, np.full(_EDGE_SAMPLES, span_y[0]))[1].max())
    bottom = float(rays(span_x, np.full(_EDGE_SAMPLES, span_y[-1]))[1].min())
    return dataclasses.replace(
        camera,
        width=int((right - left) * camera.fx) + 1,  # from the centre of the first pixel to that of the last
        height=int((bottom - top) * camera.fy) + 1,
        cx=0.5 - left * camera.fx,
        cy=0.5 - top * camera.fy,
    )


def straightened(
    picture: npt.NDArray[np.uint8],  # [H, W, 3]
    camera: Camera,  # of the photograph
    lens: Distortion,
    straight: Camera,  # `straight_camera` of both
) -> npt.NDArray[np.uint8]:
    """Return the picture [straight.height, straight.width, 3] without distortion, by bilinear interpolation.

    A pixel that rounding puts outside the photograph takes the colour of its edge.
    """
    if lens.is_none:
        return picture
    result = np.empty((straight.height, straight.width, 3), np.uint8)
    x = (np.arange(straight.width) + 0.5 - straight.cx) / straight.fx
    for first in range(0, straight.height, _STRIP_ROWS):
        rows = np.arange(first, min(first + _STRIP_ROWS, straight.height))
        y = (rows + 0.5 - straight.cy) / straight.fy
        bent_x, bent_y = lens.apply(*np.broadcast_arrays(x, y[:, None]))
        result[rows] = _bilinear(picture, bent_x * camera.fx + camera.cx, bent_y * camera.fy + camera.cy)
    return result


def _bilinear(picture: npt.NDArray[np.uint8], u: Floats, v: Floats) -> npt.NDArray[np.uint8]:
    """Return the picture's colours [..., 3] at pixel positions (u, v), centres at +0.5."""
    height, width = picture.shape[:2]
    column, row = np.clip(u - 0.5, 0, width - 1), np.clip(v - 0.5, 0, height - 1)
    left, top = np.minimum(column.astype(np.int32), width - 2), np.minimum(row.astype(np.int32), height - 2)
    right_share = (column - left).astype(np.float32)[..., None]
    lower_share = (row - top).astype(np.float32)[..., None]
    flat, first = picture.reshape(-1, 3), top * width + left

    def blend(offset: int) -> npt.NDArray[np.float32]:
        colours: npt.NDArray[np.float32] = flat.take(first + offset, axis=0).astype(np.float32)
        colours += right_share * (flat.take(first + offset + 1, axis=0) - colours)
        return colours

    upper = blend(0)
    upper += lower_share * (blend(width) - upper) + np.float32(0.5)
    return upper.astype(np.uint8)
