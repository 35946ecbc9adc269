"""The C structs of src/hgs_native.h, and how numpy arrays get into them."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np

from hgs_core.native.kernel_arrays import Floats, address, pointers
from hgs_core.scene.camera import Camera
from hgs_core.scene.motion import COEFFICIENTS
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = [
    "DYNAMIC_SHAPES",
    "MAX_SIDE",
    "STATIC_SHAPES",
    "CDynamicGradients",
    "CDynamicSplats",
    "CMeasurements",
    "CPicture",
    "CScreenStatistics",
    "CStaticGradients",
    "CStaticSplats",
    "CView",
    "c_camera",
    "dynamic_shapes",
    "dynamics_struct",
    "gradients_struct",
    "statics_struct",
]

MAX_SIDE = 65535  # HGS_MAX_SIDE, pixels

# Shape of one row of every parameter, in the order of the C structs.
STATIC_SHAPES: Mapping[str, tuple[int, ...]] = {
    "means": (3,),
    "log_scales": (3,),
    "quats": (4,),
    "opacity_logits": (),
    "rgb": (3,),
}
DYNAMIC_SHAPES: Mapping[str, tuple[int, ...]] = {
    "motion": (COEFFICIENTS[0], 3),  # or as `dynamic_shapes` says
    "rotation": (2, 4),
    "log_scales": (3,),
    "opacity_logits": (),
    "time_centers": (),
    "time_log_precisions": (),
    "rgb": (3,),
}


def dynamic_shapes(coefficients: int) -> Mapping[str, tuple[int, ...]]:
    """Return the shape of one row of every parameter of a dynamic set with so many coefficients of motion."""
    return {**DYNAMIC_SHAPES, "motion": (coefficients, 3)}


class CCamera(ctypes.Structure):
    """An undistorted pinhole camera."""

    _fields_ = (
        ("width", ctypes.c_int32),
        ("height", ctypes.c_int32),
        ("fx", ctypes.c_double),
        ("fy", ctypes.c_double),
        ("cx", ctypes.c_double),
        ("cy", ctypes.c_double),
        ("rotation", ctypes.c_double * 9),
        ("translation", ctypes.c_double * 3),
        ("near_plane", ctypes.c_double),
    )


class CView(ctypes.Structure):
    """The view to draw, apart from the splats."""

    _fields_ = (
        ("camera", CCamera),
        ("time", ctypes.c_double),
        ("background", ctypes.c_float * 3),
        ("antialiased", ctypes.c_int32),
        ("tile_mask", ctypes.c_void_p),
        ("statics_use", ctypes.c_int32),
        ("magnification", ctypes.c_double * 4),
    )


class CPicture(ctypes.Structure):
    """A picture, or the gradient of one."""

    _fields_ = pointers(("rgb", "alpha", "depth"))


class CStaticSplats(ctypes.Structure):
    """Splats that never change."""

    _fields_ = [("count", ctypes.c_int64), *pointers(STATIC_SHAPES)]


class CDynamicSplats(ctypes.Structure):
    """Splats that are evaluated at a time."""

    _fields_ = [("count", ctypes.c_int64), ("coefficients", ctypes.c_int64), *pointers(DYNAMIC_SHAPES)]


class CStaticGradients(ctypes.Structure):
    """Where gradients of statics go."""

    _fields_ = pointers(STATIC_SHAPES)


class CDynamicGradients(ctypes.Structure):
    """Where gradients of dynamics go."""

    _fields_ = pointers(DYNAMIC_SHAPES)


class CScreenStatistics(ctypes.Structure):
    """Where screen statistics are added up."""

    _fields_ = pointers(("pull_sum", "count"))


class CMeasurements(ctypes.Structure):
    """The counts and times of the last calls on a workspace."""

    _fields_ = (
        *(
            (name, ctypes.c_double)
            for name in ("project", "bin", "composite", "composite_backward", "project_backward")
        ),
        *((name, ctypes.c_int64) for name in ("visible_static", "visible_dynamic", "tile_entries", "evaluations")),
    )


Struct = TypeVar("Struct", bound=ctypes.Structure)


def c_camera(camera: Camera) -> CCamera:
    """Return the camera as the kernels take it.

    Raises:
        ValueError: a picture of more than 65,535 pixels along a side.
    """
    if max(camera.width, camera.height) > MAX_SIDE:
        raise ValueError(f"pictures may have {MAX_SIDE} pixels along a side, not {camera.width} x {camera.height}")
    pose = np.asarray(camera.world_to_camera, np.float64)
    return CCamera(
        camera.width,
        camera.height,
        camera.fx,
        camera.fy,
        camera.cx,
        camera.cy,
        (ctypes.c_double * 9)(*pose[:3, :3].ravel()),
        (ctypes.c_double * 3)(*pose[:3, 3]),
        camera.near,
    )


def statics_struct(splats: StaticSplats[Floats] | None) -> CStaticSplats:
    """Return the struct of a static set, or of none.

    Raises:
        ValueError: an array of another shape or type.
    """
    return _pointed(CStaticSplats(), splats, STATIC_SHAPES)


def dynamics_struct(splats: DynamicSplats[Floats] | None) -> CDynamicSplats:
    """Return the struct of a dynamic set, or of none.

    Raises:
        ValueError: an array of another shape or type.
    """
    longest = splats is not None and splats.motion.shape[1:2] == COEFFICIENTS[1:]
    coefficients = COEFFICIENTS[longest]
    return _pointed(CDynamicSplats(coefficients=coefficients), splats, dynamic_shapes(coefficients))


def _pointed(
    struct: Struct, splats: StaticSplats[Floats] | DynamicSplats[Floats] | None, shapes: Mapping[str, tuple[int, ...]]
) -> Struct:
    """Point the fields of a set's struct at its arrays; an absent set stays empty."""
    if splats is not None:
        count = len(splats)
        struct.count = count
        for name, array in splats.items():
            setattr(struct, name, address(name, array, (count, *shapes[name])))
    return struct


def gradients_struct(
    struct: ctypes.Structure, arrays: Mapping[str, Floats] | None, count: int, shapes: Mapping[str, tuple[int, ...]]
) -> Any:
    """Return a reference to the struct of where gradients go, or None for a set that is left out.

    Raises:
        ValueError: an array of another shape or type.
    """
    if arrays is None:
        return None
    for name, array in arrays.items():
        setattr(struct, name, address(f"gradient of {name}", array, (count, *shapes[name])))
    return ctypes.byref(struct)
