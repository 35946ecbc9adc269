"""Prepared splats with the numbers of a test."""

from __future__ import annotations

import numpy as np

from hgs_core.codec.encoder.prepare import PreparedDynamics
from hgs_core.codec.format.attributes import MOTION_ORDERS

__all__ = ["prepared"]


def prepared(count: int, **given: object) -> PreparedDynamics:
    """Unit balls at the origin, a hundred pixels wide, that show nothing but their place; `given` replaces arrays."""
    width = dict.fromkeys(("position", "log_scale", "rgb", "strength_by_scale", "strength_by_turn", *MOTION_ORDERS), 3)
    width |= {"rotation": 4, "turning": 4}
    plain = {
        "position": 0.0,
        "log_scale": 0.0,
        "rotation": (1.0, 0.0, 0.0, 0.0),
        "opacity": 0.5,
        "rgb": 0.5,
        "utility": 1.0,
        "scale": 100.0,
        "strength_by_scale": 0.0,
        "strength_by_turn": 0.0,
        "velocity": 0.0,
        "acceleration": 0.0,
        "jerk": 0.0,
        "turning": 0.0,
        "time_center": 0.5,
        "time_log_precision": -9.0,
    }
    arrays = {}
    for name, value in (plain | given).items():
        array = np.asarray(value, np.float64)
        if array.ndim == 1 and len(array) == count and name != "rotation":  # one number a splat
            array = array[:, None]
        arrays[name] = np.broadcast_to(array, (count, width.get(name, 1))).copy()
    orders = [arrays.pop(name) for name in MOTION_ORDERS if name in arrays]
    motion = np.stack([arrays["position"], *orders], axis=1)
    return PreparedDynamics(row=np.arange(count, dtype=np.float64)[:, None], motion=motion, **arrays)
