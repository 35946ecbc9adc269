"""The backdrop of a scene that few cameras look at: a floor, and a dome over it, on which all that stands still lies.

Where no second camera looks, nothing says how far away a pixel is. Splats that are free to lie anywhere along its ray
hang in front of the movers as soon as an eye stands beside the camera. So they lie on one closed surface around all
that moves, which every ray from inside meets once.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base.arrays import Doubles
from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.decompose.morphology import box_sum
from hgs_core.points.far_apart import level, vertical_of
from hgs_core.points.still_depths import StillDepths
from hgs_core.points.visibility import pixels_inside
from hgs_core.scene.camera import Camera

__all__ = ["Backdrop", "find_backdrop", "load_backdrop", "save_backdrop"]

_RADII = np.geomspace(1.0, 4.0, 25)  # tried radii, distances of the farthest camera: all cameras stand inside
_FLOOR_OFFSETS = (0.0, -0.02, 0.02, -0.04, 0.04, -0.06, 0.06)  # tried heights above the movers' feet, the same
_UNKNOWN = 1.25  # radius where no two pictures show enough of the dome, the same
_DIRECTIONS = 6_000  # directions from an eye inside in which pictures are compared
_EYE = 0.3  # its height, share of the radius
_BLUR = 2  # pixels; radius of the means that are compared
_LEAST_SHARED = 100  # places in two pictures from which on they are
_AGREEING = 0.5  # disagreement below which pictures show the same
_DEPTHS = ".npz"  # ending of the file of given depths
_FLOOR_SHARE = 0.02  # share of the moving points below the floor: wrong ones


@dataclass(frozen=True)
class Backdrop:
    """A horizontal floor and the dome over it, world units."""

    centre: tuple[float, ...]  # place on the floor
    up: tuple[float, ...]  # vertical of length one
    radius: float
    given: StillDepths | None = field(default=None, compare=False)  # depths that come before floor and dome

    @property
    def axes(self) -> tuple[Doubles, Doubles]:
        """Two horizontal directions [3] at right angles to each other."""
        up = np.array(self.up)
        side = np.cross(up, np.eye(3)[np.abs(up).argmin()])
        side /= np.linalg.norm(side)
        return side, np.cross(up, side)

    def depths(self, origin: Doubles, rays: Doubles) -> Doubles:
        """Return how often rays [P, 3] fit between their origin [3], inside, and the surface, [P]."""
        start, up = origin - np.array(self.centre), np.array(self.up)
        with np.errstate(divide="ignore", invalid="ignore"):
            to_floor = -(start @ up) / (rays @ up)
        a, b, c = (rays * rays).sum(1), rays @ start, float(start @ start) - self.radius**2
        to_dome = (-b + np.sqrt(np.maximum(b * b - a * c, 0.0))) / a
        return np.asarray(np.where((to_floor > 0) & (to_floor < to_dome), to_floor, to_dome))

    def nearest(self, xyz: Doubles) -> tuple[Doubles, Doubles]:
        """Return the places [P, 3] on the surface that are nearest to given ones, and its normals [P, 3] there."""
        centre, up = np.array(self.centre), np.array(self.up)
        out = xyz - centre
        height, distance = out @ up, np.linalg.norm(out, axis=1)
        outward = np.where(distance[:, None] > 0, out / np.maximum(distance, 1e-300)[:, None], up)
        flat = out - height[:, None] * up
        flat *= np.minimum(1.0, self.radius / np.maximum(np.linalg.norm(flat, axis=1), 1e-300))[:, None]
        to_floor = np.linalg.norm(out - flat, axis=1)
        to_dome = np.where(height < 0, np.inf, np.abs(self.radius - distance))
        on_floor = (to_floor < to_dome)[:, None]
        return centre + np.where(on_floor, flat, self.radius * outward), np.where(on_floor, up, outward)


def find_backdrop(
    cameras: Sequence[Camera],
    still: Sequence[tuple[npt.NDArray[np.uint8], npt.NDArray[np.bool_]]],
    moving: npt.NDArray[np.float32],
) -> Backdrop:
    """Return the backdrop of a rig around movers.

    The vertical is the direction that the cameras' horizontal axes are at right angles to. The floor lies at the feet
    of the movers. The dome stands where the pictures agree best on it, and around the cameras.

    Args:
        cameras: of the rig.
        still: their pictures [H, W, 3] without movers, and the pixels [H, W] of them that are known.
        moving: places [P, 3] of movers at several moments; those outside of the cameras' ring are wrong.
    """
    up = vertical_of(cameras)
    positions = np.array([camera.position for camera in cameras])
    middle = (positions.max(0) + positions.min(0)) / 2
    around = float(np.linalg.norm(level(positions - middle, up), axis=1).max())
    known = moving[np.linalg.norm(level(moving - middle, up), axis=1) < around].astype(np.float64)
    floor = float(np.quantile((known if len(known) else positions) @ up, _FLOOR_SHARE))
    centre = middle + (floor - middle @ up) * up
    reach = float(np.linalg.norm(positions - centre, axis=1).max())
    smooth = [(box_sum(picture.astype(np.int16), _BLUR) / (2 * _BLUR + 1) ** 2, known) for picture, known in still]
    first = Backdrop(tuple(map(float, centre)), tuple(map(float, up)), reach)
    lower = [
        dataclasses.replace(first, centre=tuple(map(float, centre + share * reach * up))) for share in _FLOOR_OFFSETS
    ]
    floored = _best(lower, [_disagreement(one, cameras, smooth)[0] for one in lower]) or first
    domes = [dataclasses.replace(floored, radius=float(share * reach)) for share in _RADII]
    found = _best(domes, [_disagreement(one, cameras, smooth)[1] for one in domes])
    return found or dataclasses.replace(floored, radius=_UNKNOWN * reach)


def _best(tried: Sequence[Backdrop], apart: Sequence[float]) -> Backdrop | None:
    """Return the one on which pictures agree best; None if they agree on none."""
    best = int(np.argmin(apart))
    return tried[best] if apart[best] < _AGREEING else None


def _disagreement(
    backdrop: Backdrop,
    cameras: Sequence[Camera],
    still: Sequence[tuple[npt.NDArray[np.floating[Any]], npt.NDArray[np.bool_]]],
) -> tuple[float, float]:
    """Return how much cameras disagree on the colours of the floor and of the dome.

    It is the variance among the cameras that see a place, share of the variance over all places; infinity where too few
    places are in two pictures.
    """
    number = np.arange(_DIRECTIONS) + 0.5
    height, azimuth = 1 - 2 * number / _DIRECTIONS, number * np.pi * (1 + 5**0.5)
    flat = np.sqrt(1 - height**2)
    axes = np.stack([*backdrop.axes, np.array(backdrop.up)])
    rays = np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), height], 1) @ axes
    eye = np.array(backdrop.centre) + _EYE * backdrop.radius * axes[2]
    xyz = eye + backdrop.depths(eye, rays)[:, None] * rays
    colours = np.full((len(cameras), len(xyz), 3), np.nan)
    for own, camera, (picture, known) in zip(colours, cameras, still, strict=True):
        rows, pixels = pixels_inside(camera, xyz)
        seen = known[pixels[:, 1], pixels[:, 0]]
        own[rows[seen]] = picture[pixels[seen, 1], pixels[seen, 0]]
    on_floor = (xyz - np.array(backdrop.centre)) @ axes[2] < 1e-6 * backdrop.radius
    shared = (~np.isnan(colours[..., 0])).sum(0) > 1
    found = []
    for part in (on_floor, ~on_floor):
        seen_twice = colours[:, part & shared]
        if seen_twice.shape[1] < _LEAST_SHARED:
            found.append(float("inf"))
            continue
        among = float(np.nanvar(seen_twice, axis=0).mean())
        found.append(among / max(float(np.nanvar(seen_twice.reshape(-1, 3), axis=0).mean()), 1e-9))
    return found[0], found[1]


def save_backdrop(path: Path, backdrop: Backdrop) -> None:
    """Write a backdrop as JSON, and its given depths beside; each file appears complete or not at all."""
    if backdrop.given is not None:
        backdrop.given.save(path.with_suffix(_DEPTHS))
    shape = {"centre": backdrop.centre, "up": backdrop.up, "radius": backdrop.radius}
    write_bytes(path, json.dumps(shape, indent=1).encode())


def load_backdrop(path: Path) -> Backdrop | None:
    """Return the backdrop of a file that `save_backdrop` wrote; None without a file.

    Raises:
        InputError: the file or that of the depths is damaged.
    """
    if not path.exists():
        return None
    try:
        read = json.loads(path.read_bytes())
        centre, up = (tuple(map(float, read[name])) for name in ("centre", "up"))
        radius = float(read["radius"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(path, f"no readable backdrop ({error})", "delete it and run hgs train again") from error
    return Backdrop(centre, up, radius, StillDepths.load(path.with_suffix(_DEPTHS)))
