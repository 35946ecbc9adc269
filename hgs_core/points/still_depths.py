"""Given depths of the still scene, kept for the training: they hold the statics that one camera alone shows."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.arrays import Doubles
from hgs_core.base.atomic import replacing
from hgs_core.base.errors import InputError
from hgs_core.points.visibility import pixels_inside
from hgs_core.scene.camera import Camera

__all__ = ["HeldPlaces", "StillDepths"]

_REACH = 0.01  # share of a picture's width to both sides, over which a surface's slope is measured
_BENT = 0.02  # share of a depth by which its surface may leave the straight line between these sides
_BEHIND = 1.1  # times the given depth: a place behind that is hidden, and not of its surface

Depths = npt.NDArray[np.float32]
Pixels = npt.NDArray[np.int64]


@dataclass(frozen=True)
class HeldPlaces:
    """Places on given surfaces for some of many points."""

    rows: npt.NDArray[np.int64]  # [R] the points
    xyz: Doubles  # [R, 3]
    normals: Doubles  # [R, 3] unit, of either sign


@dataclass(frozen=True)
class StillDepths:
    """Depths [H, W] along the axes of cameras, by their names; 0 where none is given."""

    maps: Mapping[str, Depths]

    def at(self, camera: Camera, rows: Pixels, columns: Pixels) -> tuple[Doubles, Doubles]:
        """Return the depths [P] at a camera's pixels, 0 where unknown, and the normals [P, 3] of their surfaces."""
        depths = self.maps.get(camera.name)
        if depths is None:
            return np.zeros(len(rows)), np.zeros((len(rows), 3))
        return depths[rows, columns].astype(np.float64), _normals(depths, camera, rows, columns)

    def held(self, cameras: Sequence[Camera], xyz: Doubles) -> HeldPlaces:
        """Return the places on the rays of points [P, 3], which one camera shows at most, with a given depth.

        Points behind a given surface have none.
        """
        parts = [HeldPlaces(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3)))]
        for camera in cameras:
            shown, pixels = pixels_inside(camera, xyz)
            depths, normals = self.at(camera, pixels[:, 1], pixels[:, 0])
            _, own = camera.project(xyz[shown])
            near = (depths > 0) & (own < _BEHIND * depths)
            shares = (depths[near] / own[near])[:, None]
            places = camera.position + shares * (xyz[shown[near]] - camera.position)
            parts.append(HeldPlaces(shown[near], places, normals[near]))
        return HeldPlaces(
            np.concatenate([part.rows for part in parts]),
            np.concatenate([part.xyz for part in parts]),
            np.concatenate([part.normals for part in parts]),
        )

    def save(self, path: Path) -> None:
        """Write an .npz file; it appears complete or not at all."""
        with replacing(path) as file:
            np.savez_compressed(file, np.array(list(self.maps)), *self.maps.values())

    @classmethod
    def load(cls, path: Path) -> StillDepths | None:
        """Return the depths of a file that `save` wrote; None without a file.

        Raises:
            InputError: the file is damaged.
        """
        if not path.exists():
            return None
        try:
            with np.load(path, allow_pickle=False) as file:
                names = [str(name) for name in file["arr_0"]]
                return cls({name: np.asarray(file[f"arr_{n}"], np.float32) for n, name in enumerate(names, start=1)})
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
            raise InputError(path, f"no readable depths ({error})", "delete its folder and train again") from error


def _normals(depths: Depths, camera: Camera, rows: Pixels, columns: Pixels) -> Doubles:
    """Return the normals [P, 3] at pixels; a plane's inverse depth is linear, and edges face the camera."""
    reach = max(1, round(_REACH * camera.width))
    left, right = np.maximum(columns - reach, 0), np.minimum(columns + reach, camera.width - 1)
    above, below = np.maximum(rows - reach, 0), np.minimum(rows + reach, camera.height - 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        middle = 1 / depths[rows, columns].astype(np.float64)
        across, bent_across = _slope(depths[rows, left], depths[rows, right], middle, columns - left, right - left)
        down, bent_down = _slope(depths[above, columns], depths[below, columns], middle, rows - above, below - above)
        ahead = middle - across * (columns + 0.5 - camera.cx) - down * (rows + 0.5 - camera.cy)
        normals = np.stack([across * camera.fx, down * camera.fy, ahead], 1) @ camera.world_to_camera[:3, :3]
        flat = np.maximum(bent_across, bent_down) < _BENT * middle
    rays = camera.rays(np.stack([columns + 0.5, rows + 0.5], 1))
    normals = np.where(flat[:, None], normals, rays)
    return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))


def _slope(first: Depths, last: Depths, middle: Doubles, before: Pixels, between: Pixels) -> tuple[Doubles, Doubles]:
    """Return the slopes [P] of inverse depths, a pixel, and their distances [P] from the line between both ends."""
    start = 1 / first.astype(np.float64)
    slope = (1 / last.astype(np.float64) - start) / between
    return slope, np.abs(start + slope * before - middle)
