"""The meaning of a capture's depth maps: depth.json beside them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.base.wording import shown
from hgs_core.capture.files.text_file import read_json

__all__ = ["DEPTH_FILE", "DepthScale", "Measured", "read_depth_scale"]

DEPTH_FILE = "depth.json"
"""Name of the file beside the maps."""

_CURE = 'write {"scale": 0.001} for maps in millimetres, in a world in metres'
_FIELDS = ("scale", "measured", "unknown")


class Measured(StrEnum):
    """Where a depth is measured."""

    AXIS = "axis"  # z of the camera's own coordinates
    RAY = "ray"  # distance to the camera's centre


@dataclass(frozen=True)
class DepthScale:
    """The meaning of the values in depth maps."""

    file: Path
    scale: float  # world units of a step
    measured: Measured
    unknown: float  # value of pixels without a depth

    def distances(self, values: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
        """Return values [H, W] in world units; 0 where they are unknown, not finite, or not in front of the camera."""
        steps = values.astype(np.float64)
        with np.errstate(invalid="ignore", over="ignore"):
            found = (steps * self.scale).astype(np.float32)
            known = np.isfinite(found) & (found > 0) & (steps != self.unknown)
        return np.where(known, found, np.float32(0))


def read_depth_scale(folder: Path) -> DepthScale:
    """Return the meaning of the maps in a folder, from its depth.json.

    Raises:
        InputError: the file is missing, unreadable, or has other fields or values.
    """
    file = folder / DEPTH_FILE
    if not file.exists():
        raise InputError(file, "is missing: nothing says how long a step of the depth maps is", _CURE)
    value = read_json(file, _CURE)
    if not isinstance(value, dict):
        raise InputError(file, "holds no object", _CURE)
    for name in value:
        if name not in _FIELDS:
            raise InputError(file, f"has the field {shown(name)}", f"the fields are {', '.join(_FIELDS)}")
    scale, unknown = (_number(value.get(name, default)) for name, default in (("scale", None), ("unknown", 0)))
    if scale is None or scale <= 0:
        raise InputError(file, f"scale is {shown(value.get('scale'))}, not a number above 0", _CURE)
    if unknown is None:
        problem = f"unknown is {shown(value['unknown'])}, not a number"
        raise InputError(file, problem, "give the value of pixels without depth")
    measured = value.get("measured", Measured.AXIS.value)
    if measured not in tuple(Measured):
        problem = f"measured is {shown(measured)}"
        raise InputError(file, problem, "give axis, for the z of the camera, or ray, for the distance from its centre")
    return DepthScale(file, scale, Measured(measured), unknown)


def _number(value: object) -> float | None:
    """Return a finite number; None for anything else."""
    if not isinstance(value, int | float) or isinstance(value, bool) or not math.isfinite(value):
        return None
    return float(value)
