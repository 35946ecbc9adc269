"""Paths made of a scene's manifest: around its centre, or through the cameras of its rig."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.codec.format.captured_space import CapturedSpace
from hgs_core.codec.format.manifest import Manifest, Triple
from hgs_core.film.camera_path import CameraPath, KeyFrame
from hgs_core.scene.camera import Camera

__all__ = ["orbit_path", "rig_path", "start_camera"]

_KEYS = 64  # key frames of an orbit
_SWING = 0.8  # share of the captured azimuths that a swing takes
_VERTICAL = 1e-6  # share of the scene's extent
_STILL = 10.0  # seconds of a film of a scene that lasts no time
_UNKNOWN_SWING = math.radians(20)  # either side, where the captured space is not known


def orbit_path(manifest: Manifest) -> CameraPath:
    """Return a path around the scene's centre that lasts as long as the scene (10 s for one without motion).

    It begins at the camera that viewers start at. It is one whole turn where cameras stand all round, else a swing to
    both sides and back. It stays within the captured space, where that is known.

    Raises:
        InputError: that camera stands above or below the centre.
    """
    camera, up = start_camera(manifest), np.array(manifest.up)
    offset = camera.position - manifest.center
    level = offset - float(offset @ up) * up
    if np.linalg.norm(level) < _VERTICAL * manifest.extent:
        raise InputError("--path", "the start camera stands above or below the scene's centre", "give a path file")
    space = manifest.captured_space or _around(level / np.linalg.norm(level))
    here = space.place(camera.position, manifest.center, manifest.up)
    keys = []
    for step in range(_KEYS + 1):
        share = step / _KEYS
        azimuth = here.azimuth + _turned(share, space, here.azimuth)
        ahead = math.remainder(azimuth, 2 * math.pi)
        elevation = float(np.clip(here.elevation, *space.elevations(ahead)))
        distance = float(np.clip(here.distance, *space.distances(ahead, elevation)))
        time = manifest.start + share * _seconds(manifest)
        position = _triple(np.array(manifest.center) + distance * space.direction(azimuth, elevation, up))
        keys.append(KeyFrame(time, position, manifest.center, vertical_fov(camera)))
    return CameraPath(tuple(keys))


def rig_path(manifest: Manifest) -> CameraPath:
    """Return a path through all cameras of the manifest, in order of their azimuth, that lasts as long as the scene.

    The camera looks where each one looks, at the centre's distance.

    Raises:
        InputError: the scene has a single camera.
    """
    if len(manifest.cameras) < 2:
        raise InputError("--path", "the scene has a single camera", "give orbit, or a path file")
    center, up = np.array(manifest.center), np.array(manifest.up)
    reference = np.cross(up, np.roll(up, 1) + np.array((0.1, 0.2, 0.3)))
    across = np.cross(up, reference)

    def azimuth(camera: Camera) -> float:
        offset = camera.position - center
        return math.atan2(float(offset @ across), float(offset @ reference))

    ordered = _from_the_widest_gap(sorted(((azimuth(camera), i) for i, camera in enumerate(manifest.cameras))))
    keys = []
    for place, index in enumerate(ordered):
        camera = manifest.cameras[index]
        forward = camera.world_to_camera[2, :3]
        distance = float(np.linalg.norm(camera.position - center)) or manifest.extent
        time = manifest.start + place / (len(ordered) - 1) * _seconds(manifest)
        target = camera.position + distance * forward
        keys.append(KeyFrame(time, _triple(camera.position), _triple(target), vertical_fov(camera)))
    return CameraPath(tuple(keys))


def _seconds(manifest: Manifest) -> float:
    return manifest.end - manifest.start if manifest.end > manifest.start else _STILL


def start_camera(manifest: Manifest) -> Camera:
    """Return the camera at which viewers of a wide screen start."""
    if manifest.start_views is None:
        return manifest.cameras[0]
    name = manifest.start_views.wide.camera
    return next(camera for camera in manifest.cameras if camera.name == name)


def vertical_fov(camera: Camera) -> float:
    """Return the angle between the top and the bottom of a camera's picture, degrees."""
    return math.degrees(2 * math.atan(camera.height / 2 / camera.fy))


def _from_the_widest_gap(azimuths: list[tuple[float, int]]) -> list[int]:
    """Return the cameras of ascending azimuths, from the one behind the widest gap on: no path crosses that."""
    gaps = [(azimuths[i][0] - azimuths[i - 1][0]) % (2 * math.pi) for i in range(len(azimuths))]
    first = gaps.index(max(gaps))
    return [index for _, index in azimuths[first:] + azimuths[:first]]


def _around(front: npt.NDArray[np.float64]) -> CapturedSpace:
    """Return a space to swing in where the captured one is not known."""
    anywhere = (-math.pi / 2, math.pi / 2)
    return CapturedSpace(_triple(front), _UNKNOWN_SWING / _SWING, anywhere, (1e-9, math.inf))


def _turned(share: float, space: CapturedSpace, start: float) -> float:
    """Return the angle by which an orbit has turned after a share of its time, radians."""
    if space.azimuth is None:
        return 2 * math.pi * share
    wave = math.sin(2 * math.pi * share)
    left, right = space.azimuths
    return _SWING * (wave * max(0.0, right - start) if wave >= 0 else wave * max(0.0, start - left))


def _triple(point: npt.NDArray[np.float64]) -> Triple:
    x, y, z = (float(value) for value in point)
    return x, y, z
