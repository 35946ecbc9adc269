"""The camera models of COLMAP by their names and numbers, and the lenses that they are."""

from __future__ import annotations

import math
from collections.abc import Sequence

from hgs_core.capture.lenses.lens import PINHOLE, Division, FieldOfView, Lens, Polynomial, Unified

__all__ = ["COLMAP_MODELS", "PANORAMA", "colmap_intrinsics"]

PANORAMA = "EQUIRECTANGULAR"

COLMAP_MODELS: dict[str, tuple[int, str]] = {
    "SIMPLE_PINHOLE": (0, "f cx cy"),
    "PINHOLE": (1, "fx fy cx cy"),
    "SIMPLE_RADIAL": (2, "f cx cy k1"),
    "RADIAL": (3, "f cx cy k1 k2"),
    "OPENCV": (4, "fx fy cx cy k1 k2 p1 p2"),
    "OPENCV_FISHEYE": (5, "fx fy cx cy k1 k2 k3 k4"),
    "FULL_OPENCV": (6, "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6"),
    "FOV": (7, "fx fy cx cy omega"),
    "SIMPLE_RADIAL_FISHEYE": (8, "f cx cy k1"),
    "RADIAL_FISHEYE": (9, "f cx cy k1 k2"),
    "THIN_PRISM_FISHEYE": (10, "fx fy cx cy k1 k2 p1 p2 k3 k4 s1 s3"),
    "RAD_TAN_THIN_PRISM_FISHEYE": (11, "fx fy cx cy k1 k2 k3 k4 k5 k6 p2 p1 s1 s2 s3 s4"),
    "SIMPLE_DIVISION": (12, "f cx cy k"),
    "DIVISION": (13, "fx fy cx cy k"),
    "SIMPLE_FISHEYE": (14, "f cx cy"),
    "FISHEYE": (15, "fx fy cx cy"),
    "EUCM": (16, "fx fy cx cy alpha beta"),
    PANORAMA: (17, "width height"),
}
"""The models' numbers in binary files, and their parameters in COLMAP's order, by our names."""


def colmap_intrinsics(model: str, parameters: Sequence[float]) -> tuple[float, float, float, float, Lens]:
    """Return fx, fy, cx, cy in pixels, and the lens, of a model and its parameters.

    Raises:
        ValueError: the model is unknown or a panorama, or the parameters are not as many as it has, or not finite.
    """
    if model not in COLMAP_MODELS:
        raise ValueError(f"the camera model {model} is unknown")
    if model == PANORAMA:
        raise ValueError(f"the camera model {model} is a panorama, which no flat picture shows")
    names = COLMAP_MODELS[model][1].split()
    if len(parameters) != len(names) or not all(math.isfinite(value) for value in parameters):
        raise ValueError(f"{model} has the {len(names)} numbers {', '.join(names)}, not {list(parameters)}")
    of = dict(zip(names, (float(value) for value in parameters), strict=True))
    lens = _lens(model, of)
    return of.get("fx", of.get("f", 0.0)), of.get("fy", of.get("f", 0.0)), of["cx"], of["cy"], lens


def _lens(model: str, of: dict[str, float]) -> Lens:
    if model == "FOV":
        return FieldOfView(of["omega"])
    if model.endswith("DIVISION"):
        return Division(of["k"])
    if model == "EUCM":
        return Unified(of["alpha"], of["beta"])

    def some(*names: str) -> tuple[float, ...]:
        return tuple(of.get(name, 0.0) for name in names)

    fisheye, aria = model.endswith("FISHEYE"), model.startswith("RAD_TAN")
    p1, p2, s1, s2, s3, s4 = some("p1", "p2", "s1", "s2", "s3", "s4")
    rational = model == "FULL_OPENCV"
    lens = Polynomial(
        radial=some("k1", "k2", "k3") if rational else some("k1", "k2", "k3", "k4", "k5", "k6"),
        divided=some("k4", "k5", "k6") if rational else (),
        tangential=(p1, p2),
        prism=(s1, s2, s3, s4),
        fisheye=fisheye,
        radial_first=aria,
    )
    bends = fisheye or any(some("k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2", "s1", "s2", "s3", "s4"))
    return lens if bends else PINHOLE
