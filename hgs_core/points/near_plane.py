"""Near planes: how close to a camera a splat may be drawn."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.scene.camera import Camera

__all__ = ["load_near_planes", "save_near_planes", "with_near_planes"]

_MEDIAN_SHARE = 0.08  # least share of a camera's median depth
_NEAREST_SHARE = 0.6  # share of the depth of the nearest points in view, but for one in a hundred
_PROJECTED = 1 << 20  # points at once


def with_near_planes(cameras: Sequence[Camera], points: npt.NDArray[np.float32]) -> tuple[Camera, ...]:
    """Return the cameras with near planes that suit the scene.

    In a dome every camera looks past the others, and the body of one is a surface like any other: seen from that
    camera's own place it fills the picture. And what a camera shows and too few others do, training explains by fog in
    front of that camera alone. A near plane at 60 % of the depth of the nearest of the points [P, 3] in view, at least
    8 % of their median, leaves both out, at any scale of the world.
    """
    planes = np.array([_near_plane(camera, points) for camera in cameras])
    if np.isnan(planes).all():
        return tuple(cameras)
    planes = np.where(np.isnan(planes), np.nanmedian(planes), planes)
    return tuple(dataclasses.replace(camera, near=float(near)) for camera, near in zip(cameras, planes, strict=True))


def save_near_planes(path: Path, cameras: Sequence[Camera]) -> None:
    """Write the near planes of the cameras, by name, as JSON; the file appears complete or not at all."""
    write_bytes(path, json.dumps({camera.name: camera.near for camera in cameras}, indent=1).encode())


def load_near_planes(path: Path, cameras: Sequence[Camera]) -> tuple[Camera, ...]:
    """Return the cameras with the near planes of a file that `save_near_planes` wrote, to the same bits.

    Raises:
        InputError: the file is missing or damaged, or lacks a camera.
    """
    try:
        planes = json.loads(path.read_bytes())
        return tuple(dataclasses.replace(camera, near=float(planes[camera.name])) for camera in cameras)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(path, f"no readable near planes ({error})", "delete it and run hgs train again") from error


def _near_plane(camera: Camera, points: npt.NDArray[np.float32]) -> float:
    parts = []
    for start in range(0, len(points), _PROJECTED):
        pixels, depth = camera.project(points[start : start + _PROJECTED])
        parts.append(depth[camera.shows(pixels, depth, beyond=0)])
    seen = np.concatenate(parts) if parts else np.zeros(0)
    if len(seen) == 0:
        return np.nan
    return float(max(_MEDIAN_SHARE * np.median(seen), _NEAREST_SHARE * np.percentile(seen, 1)))
