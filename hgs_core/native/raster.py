"""Rasterization and its derivative on numpy arrays."""

from __future__ import annotations

import ctypes
from collections import deque
from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from hgs_core.camera import Camera
from hgs_core.native.arrays import Floats, address, pointers
from hgs_core.native.library import check, load, thread_count
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["DYNAMIC_SHAPES", "STATIC_SHAPES", "Raster"]

# Shape of one row of every parameter, in the order of the C structs.
STATIC_SHAPES: Mapping[str, tuple[int, ...]] = {
    "means": (3,),
    "log_scales": (3,),
    "quats": (4,),
    "opacity_logits": (),
    "rgb": (3,),
}
DYNAMIC_SHAPES: Mapping[str, tuple[int, ...]] = {
    "motion": (4, 3),
    "rotation": (2, 4),
    "log_scales": (3,),
    "opacity_logits": (),
    "time_centers": (),
    "time_log_precisions": (),
    "rgb": (3,),
}


class _Camera(ctypes.Structure):
    _fields_ = (
        ("width", ctypes.c_int32),
        ("height", ctypes.c_int32),
        ("fx", ctypes.c_float),
        ("fy", ctypes.c_float),
        ("cx", ctypes.c_float),
        ("cy", ctypes.c_float),
        ("rotation", ctypes.c_float * 9),
        ("translation", ctypes.c_float * 3),
        ("near_plane", ctypes.c_float),
    )


class _StaticSplats(ctypes.Structure):
    _fields_ = [("count", ctypes.c_int64), *pointers(STATIC_SHAPES)]


class _DynamicSplats(ctypes.Structure):
    _fields_ = [("count", ctypes.c_int64), *pointers(DYNAMIC_SHAPES)]


class _StaticGradients(ctypes.Structure):
    _fields_ = pointers(STATIC_SHAPES)


class _DynamicGradients(ctypes.Structure):
    _fields_ = pointers(DYNAMIC_SHAPES)


class _ScreenStatistics(ctypes.Structure):
    _fields_ = pointers(("grad_norm_sum", "count", "max_radius"))


Struct = TypeVar("Struct", bound=ctypes.Structure)


# Workspaces that no rendering uses: handing them on keeps their buffers, and the caches, warm. A deque needs no lock,
# which a fork could leave locked.
_free_workspaces: deque[int] = deque()


def _take_workspace() -> int:
    try:
        return _free_workspaces.pop()
    except IndexError:
        create = load().hgs_workspace_create
        create.restype = ctypes.c_void_p
        workspace = create()
        if workspace is None:
            raise MemoryError("no memory for a workspace") from None
        return int(workspace)


class Raster:
    """One rendering: the picture, and what its derivative needs.

    The arrays of `static` and `dynamic` are read again by `backward` and must not change until then.
    """

    rgb: Floats  # [3, H, W] background included; not clamped
    alpha: Floats  # [H, W] 1 - transmittance

    def __init__(
        self,
        static: StaticSplats[Floats] | None,
        dynamic: DynamicSplats[Floats] | None,
        camera: Camera,
        time: float = 0.0,
        *,
        background: tuple[float, float, float] = (0.0, 0.0, 0.0),
        tile_mask: npt.NDArray[np.bool_] | None = None,
        threads: int | None = None,
    ) -> None:
        """Draw both sets at normalised `time`.

        Args:
            static: float32, contiguous, or None.
            dynamic: float32, contiguous, or None.
            camera: the view and the size of the picture.
            time: normalised time of the dynamic set.
            background: colour behind everything.
            tile_mask: [ceil(H / 16), ceil(W / 16)]; tiles that are False show the background.
            threads: default `thread_count()`.

        Raises:
            ValueError: an array of another shape or type.
            RuntimeError: no compiled library, or more than 2^31 - 1 pairs of splats and tiles.
            MemoryError: not enough memory for them.
        """
        self._workspace: int | None = None
        self._threads = threads or thread_count()
        self._static = _fill(_StaticSplats(), static, STATIC_SHAPES)
        self._dynamic = _fill(_DynamicSplats(), dynamic, DYNAMIC_SHAPES)
        self._arrays = (static, dynamic)  # the structs point into them
        self._shape = (camera.height, camera.width)
        mask = None
        if tile_mask is not None:
            tiles = (-(-camera.height // 16), -(-camera.width // 16))
            mask = address("tile_mask", tile_mask, tiles, np.bool_)
        self.rgb = np.empty((3, *self._shape), np.float32)
        self.alpha = np.empty(self._shape, np.float32)
        self._workspace = _take_workspace()
        status = load().hgs_rasterize(
            ctypes.c_void_p(self._workspace),
            ctypes.byref(_camera(camera)),
            ctypes.byref(self._static),
            ctypes.byref(self._dynamic),
            ctypes.c_float(time),
            (ctypes.c_float * 3)(*background),
            ctypes.c_void_p(mask),
            self._threads,
            ctypes.c_void_p(self.rgb.ctypes.data),
            ctypes.c_void_p(self.alpha.ctypes.data),
        )
        check(status)

    def __del__(self) -> None:
        self.release()

    def release(self) -> None:
        """Let the next rendering use the workspace; `backward` is not possible afterwards."""
        if self._workspace is not None:
            _free_workspaces.append(self._workspace)
            self._workspace = None

    def backward(
        self,
        grad_rgb: Floats,
        grad_alpha: Floats | None,
        grad_static: Mapping[str, Floats] | None,
        grad_dynamic: Mapping[str, Floats] | None,
        statistics: tuple[Floats, npt.NDArray[np.int32], Floats] | None = None,
    ) -> None:
        """Differentiate the rendering with respect to the sets that are given somewhere to write to.

        Args:
            grad_rgb: [3, H, W] dL / d rgb.
            grad_alpha: [H, W] dL / d alpha, or None if that is zero.
            grad_static: parameter name -> array of its shape, overwritten; None leaves the statics out.
            grad_dynamic: the same for the dynamics.
            statistics: gradient norm sums, counts and radii of `hgs_core.render.ScreenStatistics`, added to.

        Raises:
            ValueError: an array of another shape or type.
            RuntimeError: `release` was called.
            MemoryError: not enough memory for the gradients of the tiles.
        """
        if self._workspace is None:
            raise RuntimeError("backward after release")
        count = self._static.count + self._dynamic.count
        gathered = None
        if statistics is not None:
            gathered = _ScreenStatistics(
                address("grad_norm_sum", statistics[0], (count,)),
                address("count", statistics[1], (count,), np.int32),
                address("max_radius", statistics[2], (count,)),
            )
        into_static = _gradients(_StaticGradients(), grad_static, self._static.count, STATIC_SHAPES)
        into_dynamic = _gradients(_DynamicGradients(), grad_dynamic, self._dynamic.count, DYNAMIC_SHAPES)
        status = load().hgs_rasterize_backward(
            ctypes.c_void_p(self._workspace),
            ctypes.byref(self._static),
            ctypes.byref(self._dynamic),
            ctypes.c_void_p(self.rgb.ctypes.data),
            ctypes.c_void_p(self.alpha.ctypes.data),
            ctypes.c_void_p(address("grad_rgb", grad_rgb, (3, *self._shape))),
            ctypes.c_void_p(None if grad_alpha is None else address("grad_alpha", grad_alpha, self._shape)),
            into_static,
            into_dynamic,
            None if gathered is None else ctypes.byref(gathered),
            self._threads,
        )
        check(status)


def _camera(camera: Camera) -> _Camera:
    pose = camera.world_to_camera
    return _Camera(
        camera.width,
        camera.height,
        camera.fx,
        camera.fy,
        camera.cx,
        camera.cy,
        (ctypes.c_float * 9)(*pose[:3, :3].ravel()),
        (ctypes.c_float * 3)(*pose[:3, 3]),
        camera.near,
    )


def _fill(
    struct: Struct, splats: StaticSplats[Floats] | DynamicSplats[Floats] | None, shapes: Mapping[str, tuple[int, ...]]
) -> Struct:
    """Point the fields of a set's struct at its arrays; an absent set stays empty."""
    if splats is not None:
        count = len(splats)
        struct.count = count
        for name, array in splats.items():
            setattr(struct, name, address(name, array, (count, *shapes[name])))
    return struct


def _gradients(
    struct: ctypes.Structure, arrays: Mapping[str, Floats] | None, count: int, shapes: Mapping[str, tuple[int, ...]]
) -> Any:
    """Return a reference to the struct of where gradients go, or None for a set that is left out."""
    if arrays is None:
        return None
    for name, array in arrays.items():
        setattr(struct, name, address(f"gradient of {name}", array, (count, *shapes[name])))
    return ctypes.byref(struct)
