"""The points that splats start from."""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError

__all__ = ["CURE", "PointCloud"]

CURE = "delete it and near.json beside it, and run hgs train again"
"""The cure for a damaged file of first points."""

_ROW = {"xyz": (3,), "rgb": (3,), "times": (), "dynamic": (), "spacing": (), "velocity": (3,), "normal": (3,)}


@dataclass(frozen=True)
class PointCloud:
    """P points of a scene, each seen at one moment."""

    xyz: npt.NDArray[np.float32]  # [P, 3] world units
    rgb: npt.NDArray[np.float32]  # [P, 3] sRGB in [0, 1]
    times: npt.NDArray[np.float32]  # [P] seconds; the frame a point was seen in
    dynamic: npt.NDArray[np.float32]  # [P] share of the views that see it whose mask says it moves, 0..1
    spacing: npt.NDArray[np.float32]  # [P] typical distance to the neighbours, world units, positive
    velocity: npt.NDArray[np.float32]  # [P, 3] world units per second; zero where it is not known
    normal: npt.NDArray[np.float32]  # [P, 3] unit, of the surface it lies on, of either sign; zero where none is known

    @staticmethod
    def at_rest(
        xyz: npt.NDArray[np.float32],
        rgb: npt.NDArray[np.float32],
        times: npt.NDArray[np.float32],
        dynamic: npt.NDArray[np.float32],
        spacing: npt.NDArray[np.float32],
    ) -> PointCloud:
        """Return points without known motion or surfaces."""
        return PointCloud(xyz, rgb, times, dynamic, spacing, np.zeros_like(xyz), np.zeros_like(xyz))

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.xyz)

    def take(self, index: Any) -> PointCloud:
        """Return the points that `index` (mask, slice or indices) selects."""
        return PointCloud(*(getattr(self, name)[index] for name in _ROW))

    @staticmethod
    def concatenate(clouds: Sequence[PointCloud]) -> PointCloud:
        """Return the points of all clouds, in order."""
        if not clouds:
            return PointCloud(*(np.zeros((0, *row), np.float32) for row in _ROW.values()))
        return PointCloud(*(np.concatenate([getattr(cloud, name) for cloud in clouds]) for name in _ROW))

    @classmethod
    def load(cls, path: Path) -> PointCloud:
        """Read a file of first points (`FoundPoints.save`).

        Raises:
            InputError: the file is missing, unreadable, or an array is missing, of a wrong shape or not finite.
        """
        try:
            with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
                arrays = {name: np.asarray(file[name], np.float32) for name in _ROW}
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
            raise InputError(path, f"unreadable as a point cloud ({error})", CURE) from error
        for name, row in _ROW.items():
            if arrays[name].shape != (len(arrays["xyz"]), *row) or not np.isfinite(arrays[name]).all():
                raise InputError(path, f"{name} is not a finite array of shape (points, *{row})", CURE)
        return cls(**arrays)
