"""Paths of a camera: key frames on the scene's clock, and smooth motion through them."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.codec.format.json_fields import Field, field_of
from hgs_core.codec.format.manifest import Triple
from hgs_core.scene.camera import Camera, looking_at

__all__ = ["CameraPath", "KeyFrame", "load_camera_path"]

FORMAT, VERSION = "hgs-camera-path", 1

_LARGEST_FILE = 16 << 20  # bytes; a key frame for each frame of an hour
_WIDEST, _NARROWEST = 170.0, 0.5  # degrees
_STEEPEST = math.sin(math.radians(89.5))  # cosine between a view and the vertical, at most
_NEAR = 0.15  # share of the target's distance


@dataclass(frozen=True)
class KeyFrame:
    """One camera of a path."""

    time: float  # seconds of the scene's clock
    position: Triple  # world units
    target: Triple  # point in the middle of the picture, world units
    vertical_fov: float  # degrees, 0.5 to 170

    def to_json(self) -> dict[str, Any]:
        """Return the plain form."""
        return {
            "time": self.time,
            "position": list(self.position),
            "target": list(self.target),
            "vertical_fov": self.vertical_fov,
        }

    @classmethod
    def read(cls, field: Field) -> KeyFrame:
        """Read the plain form.

        Raises:
            InputError: names the field, the value and the expectation.
        """
        x, y, z = field["position"].numbers(3)
        a, b, c = field["target"].numbers(3)
        if (x, y, z) == (a, b, c):
            raise field["target"].error("is where the camera stands", "give a point in front of it")
        fov = field["vertical_fov"].number()
        if not _NARROWEST <= fov <= _WIDEST:
            raise field["vertical_fov"].error(f"is {fov:g}, expected {_NARROWEST:g} to {_WIDEST:g} degrees")
        return cls(field["time"].number(), (x, y, z), (a, b, c), fov)


@dataclass(frozen=True)
class CameraPath:
    """Key frames in order of time; before the first and after the last one the camera stands still."""

    keys: tuple[KeyFrame, ...]

    @property
    def start(self) -> float:
        """Seconds of the scene's clock at the first key frame."""
        return self.keys[0].time

    @property
    def end(self) -> float:
        """Seconds of the scene's clock at the last key frame."""
        return self.keys[-1].time

    def camera(self, time: float, size: tuple[int, int], up: Triple, near: float = 0.0) -> Camera:
        """Return the camera at a time.

        Positions, targets and the logarithm of the focal length are cubic Hermite curves. Their slopes at key frames
        are those of the parabola through a key frame and its neighbours, so that even motion stays even. Splats nearer
        than 0.15 of the target's distance are not drawn: in viewers they fade.

        Args:
            time: seconds of the scene's clock.
            size: width and height of the picture, pixels.
            up: upward unit vector of the world.
            near: least distance of what is drawn, world units.

        Raises:
            InputError: the curve leads the camera to its own target, or looks straight up or down.
        """
        lens = [-math.log(math.tan(math.radians(key.vertical_fov) / 2)) for key in self.keys]
        values = np.array([(*key.position, *key.target, one) for key, one in zip(self.keys, lens, strict=True)])
        found = _hermite(np.array([key.time for key in self.keys]), values, time)
        position, target = found[:3], found[3:6]
        forward = target - position
        distance = float(np.linalg.norm(forward))
        where = f"camera path at {time:.3f} s"
        if distance < 1e-9:
            raise InputError(where, "the camera is at its own target", "add key frames, or move the targets")
        if abs(float(forward @ np.asarray(up))) > _STEEPEST * distance:
            raise InputError(where, "the camera looks straight up or down", "move the camera or its target aside")
        width, height = size
        focal = height / 2 * math.exp(float(found[6]))
        pose = looking_at(position, target, up=up)
        return Camera("film", width, height, focal, focal, width / 2, height / 2, pose, max(near, _NEAR * distance))

    def to_json(self) -> dict[str, Any]:
        """Return the plain form, which `load_camera_path` reads."""
        return {"format": FORMAT, "version": VERSION, "keys": [key.to_json() for key in self.keys]}


def load_camera_path(file: Path) -> CameraPath:
    """Read a path's JSON file: `{"format": "hgs-camera-path", "version": 1, "keys": [...]}`, a `KeyFrame` each.

    Raises:
        InputError: the file cannot be read, is too large or no JSON, or a field is wrong; names file and field.
    """
    try:
        with file.open("rb") as opened:
            data = opened.read(_LARGEST_FILE + 1)
        if len(data) > _LARGEST_FILE:
            raise InputError(file, f"is larger than {_LARGEST_FILE >> 20} MiB", "give fewer key frames")
        document = json.loads(data)
    except OSError as error:
        raise InputError(file, f"cannot be read ({error.strerror})", "give orbit, cameras or a JSON file") from error
    except (ValueError, RecursionError) as error:
        raise InputError(file, f"is no JSON ({error})", "write it as docs/interchange.md says") from error
    root = field_of(document, file)
    if not isinstance(document, dict) or "format" not in document:
        raise InputError(file, "is no camera path: it has no format", "write it as docs/interchange.md says")
    if root["format"].text() != FORMAT:
        raise root["format"].error(f"is {root['format'].value!r}, expected {FORMAT!r}")
    root["version"].whole(VERSION, VERSION)
    keys = tuple(map(KeyFrame.read, root["keys"].items()))
    if not keys:
        raise root["keys"].error("is empty, expected at least one key frame")
    for i in range(1, len(keys)):
        if keys[i].time <= keys[i - 1].time:
            raise root["keys"].items()[i]["time"].error(f"is {keys[i].time:g}, not after the one before")
    return CameraPath(keys)


def _hermite(times: npt.NDArray[np.float64], values: npt.NDArray[np.float64], at: float) -> npt.NDArray[np.float64]:
    """Return the curve through values [K, D] at strictly rising times [K]."""
    if len(times) == 1 or at <= times[0]:
        return np.asarray(values[0])
    if at >= times[-1]:
        return np.asarray(values[-1])
    left = int(np.searchsorted(times, at, side="right")) - 1
    step = times[left + 1] - times[left]
    first, last = (_slope(times, values, place) * step for place in (left, left + 1))
    s = (at - times[left]) / step
    begin, end = values[left], values[left + 1]
    return np.asarray(
        begin * (1 + 2 * s) * (1 - s) ** 2
        + first * s * (1 - s) ** 2
        + end * s * s * (3 - 2 * s)
        + last * s * s * (s - 1)
    )


def _slope(times: npt.NDArray[np.float64], values: npt.NDArray[np.float64], place: int) -> npt.NDArray[np.float64]:
    """Return the derivative [D] at a key frame: of the parabola through three, of the line through two at the ends."""
    around: Sequence[int] = range(max(0, place - 1), min(len(times), place + 2))
    slopes = [(values[i + 1] - values[i]) / (times[i + 1] - times[i]) for i in around[:-1]]
    if len(slopes) == 1:
        return np.asarray(slopes[0])
    before, after = times[place] - times[place - 1], times[place + 1] - times[place]
    return np.asarray((slopes[0] * after + slopes[1] * before) / (before + after))
