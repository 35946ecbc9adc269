"""Cameras of Google Immersive captures: models.json.

A list of fisheye cameras (Broxton et al., SIGGRAPH 2020): `orientation` is the axis times the angle of the rotation
from the world to the camera, `position` the camera's place in the world, and `radial_distortion` k1, k2, k3 of the
angle from the axis.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.base.wording import shown
from hgs_core.capture.cameras.rig import (
    CalibratedCamera,
    CameraFormat,
    Rig,
    finite,
    lens_numbers,
    pose_of,
    rotation_matrix,
)
from hgs_core.capture.files.text_file import read_json
from hgs_core.capture.lenses.lens import Polynomial

__all__ = ["IMMERSIVE", "MODELS_FILE"]

MODELS_FILE = "models.json"


def _read(capture: Path, file: Path) -> Rig:
    models: Any = read_json(file, "restore the file from its source")
    if not isinstance(models, list) or not models or not all(isinstance(model, dict) for model in models):
        raise InputError(file, "is not a list of cameras", "restore the file from its source")
    return Rig((file,), [_camera(model, f"{file}, camera {number}") for number, model in enumerate(models)])


def _camera(model: dict[str, Any], where: str) -> CalibratedCamera:
    needed = ("name", "width", "height", "focal_length", "principal_point", "orientation", "position")
    missing = [name for name in needed if name not in model]
    if missing:
        raise InputError(where, f"the field {missing[0]!r} is missing", "restore the file from its source")
    kind = model.get("projection_type", "fisheye")
    if kind != "fisheye":
        raise InputError(where, f"projection_type is {shown(kind)}", "only fisheye cameras are known in this file")
    rotation = rotation_matrix(model["orientation"], f"{where}, orientation")
    position = finite(model["position"], 3, where, "position")
    focal = float(finite([model["focal_length"]], 1, where, "focal_length")[0])
    aspect = float(finite([model.get("pixel_aspect_ratio", 1.0)], 1, where, "pixel_aspect_ratio")[0])
    width, height = finite([model["width"], model["height"]], 2, where, "width, height")
    cx, cy = finite(model["principal_point"], 2, where, "principal_point")
    coefficients = lens_numbers(model.get("radial_distortion"), where, "radial_distortion")
    return CalibratedCamera(
        where,
        (str(model["name"]),),
        pose_of(rotation, -rotation @ position, where),
        (focal, focal * aspect),
        (float(cx), float(cy)),
        (float(width), float(height)),
        Polynomial(radial=tuple(coefficients), fisheye=True),
    )


def _find(capture: Path) -> Path | None:
    return file if (file := capture / MODELS_FILE).is_file() else None


IMMERSIVE = CameraFormat("Google Immersive", MODELS_FILE, _find, _read)
