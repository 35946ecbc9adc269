"""Pictures freed from the distortion of their lens, and the pinhole cameras that would have taken them."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.capture.lenses.lens import PINHOLE, Lens
from hgs_core.capture.lenses.sensor_places import sensor_places
from hgs_core.scene.camera import Camera

__all__ = ["WIDEST", "StraightView", "ray_of"]

WIDEST = 60.0
"""Degrees from the axis to a side of a straight picture, at most: a pinhole makes a fisheye's pixel 4 times as long."""

_FARTHEST = 80.0  # degrees from the axis up to which a lens is looked at
_STEPS = 400  # angles in the first table of the inversion
_NEWTON_STEPS = 8
_EDGE_SAMPLES = 65  # points on each side of the picture

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class StraightView:
    """One camera's pictures as they are and as they are shown: through its lens, and straight."""

    bent: Camera  # focal lengths and centre of the pictures as they are
    lens: Lens
    camera: Camera  # camera of the straight picture
    cut: bool = False  # whether the lens sees farther to a side than the straight picture shows

    @classmethod
    def of(cls, bent: Camera, lens: Lens) -> StraightView:
        """Return the view of the largest straight rectangle that the photograph covers.

        No pixel of it lies outside the photograph, and what bends over its edges is cut off; so is what lies more than
        60 degrees from the axis to a side: it has hardly more than twice the photograph's pixels then. Focal lengths
        stay, so that the middle keeps its sharpness.

        Raises:
            InputError: the coefficients fold the picture over itself.
        """
        if lens == PINHOLE:
            return cls(bent, lens, bent)
        span_x = np.linspace(0.5, bent.width - 0.5, _EDGE_SAMPLES)
        span_y = np.linspace(0.5, bent.height - 0.5, _EDGE_SAMPLES)

        def rays(u: Floats, v: Floats) -> tuple[Floats, Floats]:
            x, y, folded = ray_of(lens, (u - bent.cx) / bent.fx, (v - bent.cy) / bent.fy)
            if folded.any():
                cure = "calibrate it again, or with a model of fewer coefficients"
                raise InputError(f"camera {bent.name}", "its distortion coefficients fold the picture", cure)
            return x, y

        left = float(rays(np.full(_EDGE_SAMPLES, span_x[0]), span_y)[0].max())
        right = float(rays(np.full(_EDGE_SAMPLES, span_x[-1]), span_y)[0].min())
        top = float(rays(span_x, np.full(_EDGE_SAMPLES, span_y[0]))[1].max())
        bottom = float(rays(span_x, np.full(_EDGE_SAMPLES, span_y[-1]))[1].min())
        limit = math.tan(math.radians(WIDEST))
        cut = max(-left, right, -top, bottom) > limit
        left, right, top, bottom = max(left, -limit), min(right, limit), max(top, -limit), min(bottom, limit)
        if not (left < right and top < bottom):
            problem = "its lens leaves no straight picture"
            raise InputError(f"camera {bent.name}", problem, "check its principal point and distortion coefficients")
        straight = dataclasses.replace(
            bent,
            width=int((right - left) * bent.fx) + 1,  # first to last pixel centre
            height=int((bottom - top) * bent.fy) + 1,
            cx=0.5 - left * bent.fx,
            cy=0.5 - top * bent.fy,
        )
        return cls(bent, lens, straight, cut)

    def straightened(self, picture: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
        """Return the picture [H, W, C] without distortion, by bilinear interpolation.

        A pixel that rounding puts outside the photograph takes the colour of its edge.
        """
        if self.lens == PINHOLE:
            return picture
        straight = self.camera
        places = sensor_places(self.bent, self.lens, straight)
        return places.blended(picture).reshape(straight.height, straight.width, -1)

    def straight_mask(self, mask: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
        """Return the mask [H, W] without distortion: a pixel is set if half of its area is."""
        if self.lens == PINHOLE:
            return mask
        return self.straightened(mask[..., None].astype(np.uint8) * 255)[..., 0] >= 128


def ray_of(lens: Lens, u: Floats, v: Floats) -> tuple[Floats, Floats, npt.NDArray[np.bool_]]:
    """Return the rays (x, y, 1) that meet the sensor at (u, v), and where the lens folds before it reaches them.

    All are [N]. A ray more than 80 degrees from the axis is returned as the one of 80 degrees in its direction.
    """
    distance = np.hypot(u, v)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        across, down = np.where(distance > 0, u / distance, 1.0), np.where(distance > 0, v / distance, 0.0)
        angles = np.linspace(0.0, math.radians(_FARTHEST), _STEPS)
        radius = np.tan(angles)
        bent = lens.apply(across[:, None] * radius, down[:, None] * radius)
        reached = bent[0] * across[:, None] + bent[1] * down[:, None]  # [N, steps] along the point's own direction
        rising = np.diff(reached, axis=1) > 0
        turn = np.where(rising.all(axis=1), _STEPS - 1, (~rising).argmax(axis=1))  # the last step before it folds
        beyond = reached[np.arange(len(u)), turn] < distance
        folded = beyond & (turn < _STEPS - 1)
        rising_to = np.arange(_STEPS) <= turn[:, None]
        place = ((reached < distance[:, None]) & rising_to).sum(axis=1)  # the first step that is beyond the point
        start = np.tan(angles[np.clip(place, 0, turn)])
        x, y = across * start, down * start
        for _ in range(_NEWTON_STEPS):
            x, y = _newton_step(lens, x, y, u, v)
    far = math.tan(math.radians(_FARTHEST))
    lost = beyond | ~np.isfinite(x) | ~np.isfinite(y) | (np.hypot(x, y) > far)
    return np.where(lost, across * far, x), np.where(lost, down * far, y), folded


def _newton_step(lens: Lens, x: Floats, y: Floats, u: Floats, v: Floats) -> tuple[Floats, Floats]:
    """Return rays that meet the sensor nearer to (u, v), by the lens's derivative at the rays (x, y, 1)."""
    step = 1e-6
    at_u, at_v = lens.apply(x, y)
    right_u, right_v = lens.apply(x + step, y)
    down_u, down_v = lens.apply(x, y + step)
    a, b, c, d = (right_u - at_u) / step, (down_u - at_u) / step, (right_v - at_v) / step, (down_v - at_v) / step
    miss_u, miss_v = u - at_u, v - at_v
    determinant = a * d - b * c
    return x + (d * miss_u - b * miss_v) / determinant, y + (a * miss_v - c * miss_u) / determinant
