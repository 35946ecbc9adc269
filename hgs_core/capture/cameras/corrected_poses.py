"""Poses with a mistake undone: poses.json, beside any calibration, which stays as it is.

`hgs check --fix-poses` writes it: `cameras` has, for each corrected camera, the pose `world_to_camera` [4, 4] (OpenCV:
x right, y down, z forward), the camera of whose `calibration` lens and size are taken, and the factor `focal` of the
focal length. `of` is a digest of the calibration's files, for a calibration that has changed has other mistakes.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.base.wording import shown
from hgs_core.capture.cameras.camera_formats import calibration
from hgs_core.capture.cameras.rig import CalibratedCamera, Rig, finite
from hgs_core.capture.files.text_file import read_json
from hgs_core.scene.camera import is_orthonormal

__all__ = ["CORRECTIONS_FILE", "CorrectedCamera", "corrections_of", "with_corrections", "write_corrections"]

CORRECTIONS_FILE = "poses.json"
_CURE = "remove it, and let hgs check --fix-poses write it again"
_STRONGEST = 1e3  # factor of a focal length, and its inverse


@dataclass(frozen=True, eq=False)
class CorrectedCamera:
    """One camera as it should be."""

    name: str
    world_to_camera: npt.NDArray[np.float64]  # [4, 4]
    calibration: str  # the camera whose lens and size it has
    focal: float = 1.0  # factor of that camera's focal length

    def after(self, earlier: CorrectedCamera | None) -> CorrectedCamera:
        """Return the correction of a calibration that `earlier` had corrected before; of the camera `calibration`."""
        if earlier is None:
            return self
        return dataclasses.replace(self, calibration=earlier.calibration, focal=self.focal * earlier.focal)


def write_corrections(capture: Path, because: str, cameras: Iterable[CorrectedCamera]) -> Path:
    """Write poses.json into the folder of a capture, all at once, and return it; `because` is for people."""
    camera_format, calibrated = next(calibration(capture))
    content = {
        "because": because,
        "of": camera_format.read(capture, calibrated).digest(),
        "cameras": {
            one.name: {
                "world_to_camera": one.world_to_camera.tolist(),
                "calibration": one.calibration,
                "focal": one.focal,
            }
            for one in cameras
        },
    }
    file = capture / CORRECTIONS_FILE
    write_bytes(file, json.dumps(content, indent=1, allow_nan=False).encode() + b"\n")
    return file


def corrections_of(capture: Path, names: Sequence[str]) -> dict[str, CorrectedCamera]:
    """Return the corrections of poses.json, by names out of these; none without the file.

    Raises:
        InputError: it is unreadable, or says something else than the module's description.
    """
    file = capture / CORRECTIONS_FILE
    return _cameras(file, _content(file), names) if file.is_file() else {}


def with_corrections(capture: Path, rig: Rig, names: Sequence[str]) -> Rig:
    """Return the rig of cameras of these names as poses.json in the capture's folder corrects it.

    Raises:
        InputError: the file is unreadable or of another calibration, or has a camera that the rig has not.
    """
    file = capture / CORRECTIONS_FILE
    if not file.is_file():
        return rig
    content = _content(file)
    found = _cameras(file, content, names)
    if content["of"] != rig.digest():
        changed = ", ".join(one.name for one in rig.files)
        raise InputError(file, f"corrects poses of other files than {changed} as it is now", _CURE)
    if rig.mirrored and set(found) != set(names):
        raise InputError(file, "does not correct all cameras, whose poses are reflections", _CURE)
    of = dict(zip(names, rig.cameras, strict=True))
    cameras = [_corrected(of, found.get(name), camera) for name, camera in of.items()]
    said = f"{file.name} corrects {rig.files[0].name}: {shown(content.get('because', 'nothing says why'))}"
    return dataclasses.replace(
        rig, files=(*rig.files, file), cameras=cameras, mirrored=False, notes=(*_without_mirror(rig), said)
    )


def _content(file: Path) -> dict[str, Any]:
    """Return the content of a file: cameras, one at least, and the digest of their calibration."""
    content: Any = read_json(file, _CURE)
    cameras = content.get("cameras") if isinstance(content, dict) else None
    if not isinstance(cameras, dict) or not cameras or not isinstance(content.get("of"), str):
        raise InputError(file, "has no cameras, or does not say of which calibration", _CURE)
    return dict(content)


def _cameras(file: Path, content: dict[str, Any], names: Sequence[str]) -> dict[str, CorrectedCamera]:
    return {name: _camera(f"{file}, camera {name}", name, value, names) for name, value in content["cameras"].items()}


def _without_mirror(rig: Rig) -> tuple[str, ...]:
    return rig.notes[:-1] if rig.mirrored else rig.notes


def _corrected(
    of: dict[str, CalibratedCamera], found: CorrectedCamera | None, camera: CalibratedCamera
) -> CalibratedCamera:
    if found is None:
        return camera
    lens = of[found.calibration]
    return dataclasses.replace(
        camera,
        world_to_camera=found.world_to_camera,
        focal=(lens.focal[0] * found.focal, lens.focal[1] * found.focal),
        centre=lens.centre,
        size=lens.size,
        lens=lens.lens,
    )


def _camera(where: str, name: str, value: Any, names: Sequence[str]) -> CorrectedCamera:
    if not isinstance(value, dict) or set(value) != {"world_to_camera", "calibration", "focal"}:
        raise InputError(where, f"is {shown(value)}", _CURE)
    for camera in (name, value["calibration"]):
        if camera not in names:
            raise InputError(
                where, f"there is no camera {shown(camera)}", f"{_CURE}; the cameras are {', '.join(names)}"
            )
    pose = finite(value["world_to_camera"], 16, where, "world_to_camera").reshape(4, 4)
    turn = pose[:3, :3]
    if not is_orthonormal(turn) or np.linalg.det(turn) < 0:
        raise InputError(where, "world_to_camera has no rotation", _CURE)
    focal = float(finite([value["focal"]], 1, where, "focal")[0])
    if not 1 / _STRONGEST < focal < _STRONGEST:
        raise InputError(where, f"focal is {focal:g}", "it is the factor of a focal length")
    return CorrectedCamera(name, pose, value["calibration"], focal)
