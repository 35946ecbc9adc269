"""Turning, moving and scaling a scene with everything that lies in its world."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.base.errors import InputError
from hgs_core.edit.viewed_scene import Edit, ViewedScene
from hgs_core.scene.camera import Camera
from hgs_core.scene.rotations import matrices, product, unit_quaternions
from hgs_core.scene.splat_limits import LARGEST_COORDINATE, LARGEST_LOG_SCALE
from hgs_core.scene.splats import DynamicSplats, HybridScene, StaticSplats

__all__ = ["UPWARDS", "Similarity", "orient", "turn_about", "turn_up"]

UPWARDS = (0.0, -1.0, 0.0)
"""Which way is up where nothing else says so: y points down, as in cameras."""


@dataclass(frozen=True, eq=False)
class Similarity:
    """x' = scale R x + shift."""

    quaternion: Doubles  # [4] of R; unit length, w first
    scale: float  # above 0
    shift: Doubles  # [3] world units

    @property
    def rotation(self) -> Doubles:
        """R, [3, 3]."""
        return matrices(self.quaternion)

    def then(self, other: Similarity) -> Similarity:
        """Return this one, followed by another."""
        shift = other.scale * other.rotation @ self.shift + other.shift
        return Similarity(product(other.quaternion, self.quaternion), self.scale * other.scale, shift)


def turn_about(numbers: list[float]) -> Doubles:
    """Return the unit quaternion of an axis (3) and degrees, counter-clockwise seen from the axis's tip.

    Raises:
        InputError: another count, or an axis of no length.
    """
    axis = np.array(numbers[:3])
    if len(numbers) != 4 or not np.isfinite(numbers).all() or np.linalg.norm(axis) < 1e-9:
        raise InputError("--rotate", "is no axis and angle", "give x,y,z,degrees with an axis of some length")
    half = math.radians(numbers[3]) / 2
    return np.concatenate([[math.cos(half)], math.sin(half) * axis / np.linalg.norm(axis)])


def turn_up(numbers: list[float]) -> Doubles:
    """Return the shortest turn, a unit quaternion, that makes a direction (3) of the scene point upwards.

    Raises:
        InputError: another count, or a direction of no length.
    """
    if len(numbers) != 3 or not np.isfinite(numbers).all() or np.linalg.norm(numbers) < 1e-9:
        raise InputError("--up", "is no direction", "give x,y,z of the scene's world that point up")
    up = np.array(numbers) / np.linalg.norm(numbers)
    cosine = float(up @ UPWARDS)
    if cosine < -1 + 1e-12:  # upside down: any level axis will do
        return np.array([0.0, 1.0, 0.0, 0.0])
    return np.asarray(unit_quaternions(np.concatenate([[1 + cosine], np.cross(up, UPWARDS)])[None])[0])


def orient(viewed: ViewedScene, change: Similarity, *, up: bool = False) -> Edit:
    """Turn, scale and move splats, their paths and turnings, and cameras; with `up`, -y is up from now on.

    The cameras see what they saw: their pictures are the same, but for rounding.

    Raises:
        InputError: the scale is not positive, or 32-bit numbers cannot hold the places and sizes that result.
    """
    if not (change.scale > 0 and math.isfinite(change.scale)):
        raise InputError("--scale", f"{change.scale} is not positive", "give a factor above 0")
    scene, chosen = viewed.scene, viewed.up
    if up:
        chosen = UPWARDS
    elif chosen is not None:
        x, y, z = (float(v) for v in change.rotation @ chosen)
        chosen = x, y, z
    with np.errstate(over="ignore"):  # refused below
        segments = tuple(dataclasses.replace(s, dynamic=_dynamic(s.dynamic, change)) for s in scene.segments)
        moved = dataclasses.replace(scene, static=_static(scene.static, change), segments=segments)
    _require_kept(moved)
    cameras = tuple(_camera(camera, change) for camera in viewed.cameras)
    return Edit(ViewedScene(moved, cameras, viewed.times, chosen, viewed.begins))


def _require_kept(scene: HybridScene[Floats]) -> None:
    sets: list[StaticSplats[Floats] | DynamicSplats[Floats]] = [scene.static]
    sets += [segment.dynamic for segment in scene.segments]
    places = [splats.means if isinstance(splats, StaticSplats) else splats.motion[:, 0] for splats in sets]
    farthest = max((float(np.abs(own).max(initial=0.0)) for own in places), default=0.0)
    longest = np.concatenate([splats.log_scales.max(axis=1, initial=-np.inf) for splats in sets])
    if len(longest) == 0:
        return
    usual = float(np.median(longest))
    step = float(np.spacing(np.float32(min(farthest, LARGEST_COORDINATE))))  # between neighbouring numbers
    if farthest > LARGEST_COORDINATE or abs(usual) > LARGEST_LOG_SCALE or step > math.exp(usual):
        size = f"e^{usual:.3g}" if abs(usual) > LARGEST_LOG_SCALE else f"{math.exp(usual):.2g}"
        problem = f"splats of size {size} would lie up to {farthest:.3g} from the origin, beyond 32-bit numbers"
        raise InputError("--scale and --translate", problem, "scale nearer to 1, move by less, or move back first")


def _static(splats: StaticSplats[Floats], change: Similarity) -> StaticSplats[Floats]:
    return dataclasses.replace(
        splats,
        means=_float(change.scale * splats.means.astype(np.float64) @ change.rotation.T + change.shift),
        log_scales=_float(splats.log_scales + math.log(change.scale)),
        quats=_float(product(change.quaternion, _turned(splats.quats))),
    )


def _dynamic(splats: DynamicSplats[Floats], change: Similarity) -> DynamicSplats[Floats]:
    motion = change.scale * splats.motion.astype(np.float64) @ change.rotation.T
    motion[:, 0] += change.shift
    still = np.linalg.norm(splats.rotation, axis=(1, 2)) < 1e-12
    rotation = splats.rotation.astype(np.float64)
    rotation[still, 0, 0] = 1.0
    return dataclasses.replace(
        splats,
        motion=_float(motion),
        log_scales=_float(splats.log_scales + math.log(change.scale)),
        rotation=_float(product(change.quaternion, rotation)),
    )


def _turned(quats: Floats) -> Doubles:
    """Return quaternions [N, 4] with the identity in place of those of no length, which stand for it."""
    short = np.linalg.norm(quats, axis=1) < 1e-12
    return np.where(short[:, None], (1.0, 0.0, 0.0, 0.0), quats.astype(np.float64))


def _camera(camera: Camera, change: Similarity) -> Camera:
    pose = np.eye(4)
    pose[:3, :3] = camera.world_to_camera[:3, :3] @ change.rotation.T
    pose[:3, 3] = change.scale * camera.world_to_camera[:3, 3] - pose[:3, :3] @ change.shift
    return dataclasses.replace(camera, world_to_camera=pose, near=camera.near * change.scale)


def _float(values: Doubles | Floats) -> Floats:
    return np.asarray(values, np.float32)
