"""Lens models: where the ray (x, y, 1) of a camera meets its sensor, in units of the focal length.

Three families cover every perspective and fisheye model of COLMAP and OpenCV. A polynomial lens bends the point

    u = x, v = y                              of a perspective lens,
    u = x a / r, v = y a / r, a = atan(r)     of a fisheye lens, r = sqrt(x^2 + y^2),

by, with s = u^2 + v^2,

    u' = u d + 2 p1 u v + p2 (s + 2 u^2) + s1 s + s2 s^2,   v' = v d + p1 (s + 2 v^2) + 2 p2 u v + s3 s + s4 s^2,
    d = (1 + k1 s + k2 s^2 + ...) / (1 + q1 s + q2 s^2 + ...)

(Brown 1971; the tangential terms p as OpenCV numbers them, the thin prism's s as well). A radial lens moves a point
along its radius by a formula of its own: field of view (Devernay and Faugeras 2001) and division (Fitzgibbon 2001). The
unified model (EUCM, Khomutenko 2016) divides by a mix of depth and distance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

__all__ = ["PINHOLE", "Division", "FieldOfView", "Lens", "Polynomial", "Unified", "opencv_lens"]

Floats = npt.NDArray[np.floating]


class Lens(Protocol):
    """How a lens bends rays."""

    def apply(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Return where the rays (x, y, 1) meet the sensor, in units of the focal length."""


@dataclass(frozen=True)
class Polynomial:
    """The polynomial of the module's description; without coefficients a pinhole, or an equidistant fisheye."""

    radial: tuple[float, ...] = ()  # k1, k2, ...
    divided: tuple[float, ...] = ()  # q1, q2, ...
    tangential: tuple[float, float] = (0.0, 0.0)  # p1, p2
    prism: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)  # s1, s2, s3, s4
    fisheye: bool = False
    radial_first: bool = False  # the other terms are of the point that the radial ones have moved (Project Aria)

    def apply(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """See `Lens.apply`."""
        u, v = _equidistant(x, y) if self.fisheye else (x, y)
        s = u * u + v * v
        d = _series(self.radial, s)
        if any(self.divided):
            d = d / _series(self.divided, s)
        bent_u, bent_v = u * d, v * d
        if self.radial_first:
            u, v = bent_u, bent_v
            s = u * u + v * v
        if any(self.tangential):
            p1, p2 = self.tangential
            bent_u = bent_u + 2 * p1 * u * v + p2 * (s + 2 * u * u)
            bent_v = bent_v + p1 * (s + 2 * v * v) + 2 * p2 * u * v
        if any(self.prism):
            s1, s2, s3, s4 = self.prism
            bent_u, bent_v = bent_u + s * (s1 + s2 * s), bent_v + s * (s3 + s4 * s)
        return bent_u, bent_v


PINHOLE: Lens = Polynomial()
"""The lens that bends nothing."""


@dataclass(frozen=True)
class FieldOfView:
    """The field-of-view model: r' = atan(2 r tan(omega / 2)) / omega."""

    omega: float  # radians

    def apply(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """See `Lens.apply`."""
        r = np.hypot(x, y)
        if abs(self.omega) < 1e-6:  # its limit is the pinhole
            return x, y
        bent = np.arctan(2 * r * math.tan(self.omega / 2)) / self.omega
        scale = _ratio(bent, r, 2 * math.tan(self.omega / 2) / self.omega)
        return x * scale, y * scale


@dataclass(frozen=True)
class Division:
    """The division model: a point r' of the sensor is of the ray r = r' / (1 + k r'^2)."""

    k: float

    def apply(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """See `Lens.apply`; NaN where no point of the sensor belongs to the ray."""
        root = np.sqrt(1 - 4 * self.k * (x * x + y * y))
        return 2 * x / (1 + root), 2 * y / (1 + root)


@dataclass(frozen=True)
class Unified:
    """The enhanced unified camera model: r' = r / (alpha sqrt(beta r^2 + 1) + 1 - alpha)."""

    alpha: float
    beta: float

    def apply(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """See `Lens.apply`."""
        depth = self.alpha * np.sqrt(self.beta * (x * x + y * y) + 1) + 1 - self.alpha
        return x / depth, y / depth


def opencv_lens(coefficients: Sequence[float], fisheye: bool) -> Lens:
    """Return the lens of OpenCV's list of coefficients: k1, k2, p1, p2, k3, k4...k6, s1...s4; k1...k4 of a fisheye.

    A list may end early; what is missing is 0.

    Raises:
        ValueError: more coefficients than the models have, or a tilted sensor.
    """
    given = [float(value) for value in coefficients]
    while given and given[-1] == 0.0:
        given.pop()
    if fisheye:
        if len(given) > 4:
            raise ValueError(f"{len(given)} coefficients of a fisheye lens, which has 4")
        return Polynomial(radial=tuple(given), fisheye=True)
    if len(given) > 12:
        raise ValueError("the sensor is tilted or there are more than 14 coefficients")
    if not given:
        return PINHOLE
    k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 = given + [0.0] * (12 - len(given))
    return Polynomial((k1, k2, k3), (k4, k5, k6), (p1, p2), (s1, s2, s3, s4))


def _equidistant(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    r = np.hypot(x, y)
    scale = _ratio(np.arctan(r), r, 1.0)
    return x * scale, y * scale


def _ratio(above: Floats, below: Floats, limit: float) -> Floats:
    """Return above / below, and its limit where that is 0 / 0."""
    small = below < 1e-8
    return np.where(small, below.dtype.type(limit), above / np.where(small, below.dtype.type(1), below))


def _series(coefficients: Sequence[float], s: Floats) -> Floats:
    total = np.zeros_like(s)
    for coefficient in reversed(coefficients):
        total = (total + coefficient) * s
    return total + 1
