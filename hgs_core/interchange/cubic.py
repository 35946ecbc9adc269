"""Cubic motion for formats without others: the fifth order becomes the nearest cubic over the visible life."""

from __future__ import annotations

import dataclasses

import numpy as np

from hgs_core.base.arrays import Floats
from hgs_core.scene.motion import COEFFICIENTS, position
from hgs_core.scene.polynomials import polynomial_fit, powers
from hgs_core.scene.splats import DynamicSplats
from hgs_core.scene.temporal import lifetime

__all__ = ["as_cubics"]

MOMENTS = 33  # moments of a visible life for the comparison of paths


def as_cubics(dynamic: DynamicSplats[Floats]) -> tuple[DynamicSplats[Floats], int, float]:
    """Return the splats with four coefficients of motion, how many had more, and by how much these are off.

    The cubic is the least-squares fit over the part of the segment in which a splat can be seen, squares weighed as its
    opacity's. The error is the largest displacement per axis times how much of the peak opacity is left then, world
    units. Motions that are cubics keep their bits.
    """
    cubic = dataclasses.replace(dynamic, motion=dynamic.motion[:, : COEFFICIENTS[0]])
    rows = np.flatnonzero(dynamic.motion[:, COEFFICIENTS[0] :].any(axis=(1, 2)))
    if not len(rows):
        return cubic, 0, 0.0
    start, end = (np.clip(moment, 0.0, 1.0) for moment in lifetime(dynamic.take(rows)))
    center = dynamic.time_centers[rows].astype(np.float64)
    offsets = (start + (end - start) * np.linspace(0, 1, MOMENTS)[:, None]).T - center[:, None]  # [R, MOMENTS]
    fade = np.exp(-np.exp(dynamic.time_log_precisions[rows].astype(np.float64))[:, None] * offsets**2)
    goal = position(dynamic.motion[rows].astype(np.float64)[:, None], offsets[..., None])
    middle = goal[:, MOMENTS // 2, None]  # so that nothing is lost far from the origin
    order = COEFFICIENTS[0] - 1
    found = polynomial_fit(offsets, order, goal - middle, fade**2 + 1e-12)
    error = np.abs(powers(offsets, order) @ found + middle - goal).max(axis=2) * fade
    found[:, 0] += middle[:, 0]
    motion = cubic.motion.copy()
    motion[rows] = found
    return dataclasses.replace(cubic, motion=motion), len(rows), float(error.max())
