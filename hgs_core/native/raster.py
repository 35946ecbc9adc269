"""Rasterization and its derivative on numpy arrays."""

from __future__ import annotations

import ctypes
from collections import deque
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hgs_core.base.cores import core_count
from hgs_core.native.kernel_arrays import Floats, address
from hgs_core.native.library import check, load
from hgs_core.native.structs import (
    STATIC_SHAPES,
    CDynamicGradients,
    CMeasurements,
    CPicture,
    CScreenStatistics,
    CStaticGradients,
    CView,
    c_camera,
    dynamic_shapes,
    dynamics_struct,
    gradients_struct,
    statics_struct,
)
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["Measurements", "Raster"]


class Measurements(NamedTuple):
    """The counts and times of the last calls of a rendering."""

    project: float  # seconds: splats to the screen
    bin: float  # seconds: sorting by depth, and the lists of the tiles
    composite: float  # seconds
    composite_backward: float  # seconds
    project_backward: float  # seconds
    visible_static: int  # splats
    visible_dynamic: int  # splats
    tile_entries: int  # pairs of splats and tiles
    evaluations: int  # pairs of splats and pixels that were composited, whole vectors of pixels counted


_ANEW, _KEEP, _REUSE = 0, 1, 2  # HGS_STATICS_ of src/hgs_native.h

# Workspaces that no rendering uses, at most one per core: handing them on keeps their buffers, and the caches, warm.
# More would keep the tens of MiB of each for good. A deque needs no lock, which a fork could leave locked.
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
    """One rendering: the picture, and the state for its derivative.

    The arrays of `static` and `dynamic` are read again by `backward` and must not change until then.
    """

    rgb: Floats  # [3, H, W] background included; not clamped
    alpha: Floats  # [H, W] 1 - transmittance
    depth: Floats | None  # [H, W] sum of weight times z; None unless asked for

    def __init__(
        self,
        static: StaticSplats[Floats] | None,
        dynamic: DynamicSplats[Floats] | None,
        camera: Camera,
        time: float = 0.0,
        *,
        background: tuple[float, float, float] = (0.0, 0.0, 0.0),
        tile_mask: npt.NDArray[np.bool_] | None = None,
        antialiased: bool = False,
        depth: bool = False,
        keep_statics: bool = False,
        draw: bool = True,
        threads: int | None = None,
        magnification: Iterable[float] = (0.0, 0.0, 0.0, 0.0),
    ) -> None:
        """Draw both sets at normalised `time`.

        Args:
            static: float32, contiguous, or None.
            dynamic: float32, contiguous, or None.
            camera: the view and the size of the picture.
            time: normalised time of the dynamic set.
            background: colour behind everything.
            tile_mask: [ceil(H / 16), ceil(W / 16)]; tiles that are False show the background.
            antialiased: compensate opacities for the low-pass filter (docs/numerics.md, "Antialiasing").
            depth: whether `depth` is wanted.
            keep_statics: whether `redraw` will be called.
            draw: whether there will be pictures; without, `contributions` are all that there is.
            threads: default `core_count()`.
            magnification: [4] of the view against the pictures that made the splats (`hgs_core.render.magnification`).

        Raises:
            ValueError: an array of another shape or type, or a picture that is too large.
            FloatingPointError: a parameter that was looked at is NaN or infinite, or a colour beyond 1e18.
            RuntimeError: no compiled library, or more than 2^31 - 1 pairs of splats and tiles.
            MemoryError: not enough memory for them.
        """
        self._workspace: int | None = None
        self._threads = threads or core_count()
        self._static = statics_struct(static)
        self._shape = (camera.height, camera.width)
        mask = self._mask(tile_mask)
        use = _KEEP if keep_statics else _ANEW
        self._view = CView(c_camera(camera), time, background, antialiased, mask, use, tuple(magnification))
        self._static_arrays = static  # the structs point into them
        self._workspace = _take_workspace()
        self._rasterize(dynamic, draw, depth)

    def redraw(
        self,
        dynamic: DynamicSplats[Floats] | None,
        time: float,
        depth: bool = False,
        tile_mask: npt.NDArray[np.bool_] | None = None,
        *,
        draw: bool = True,
    ) -> None:
        """Draw the same statics from the same camera with other dynamics, or at another time, into new pictures.

        The statics are neither projected nor sorted again; the mask may be another. Raises what the constructor raises;
        RuntimeError also after `release`, or without `keep_statics`.
        """
        if self._workspace is None:
            raise RuntimeError("redraw after release")
        if self._view.statics_use == _ANEW:
            raise RuntimeError("redraw of statics that were not kept")
        self._view.time = time
        self._view.tile_mask = self._mask(tile_mask)
        self._view.statics_use = _REUSE
        self._rasterize(dynamic, draw, depth)

    def _mask(self, tile_mask: npt.NDArray[np.bool_] | None) -> int | None:
        """Keep a mask and return its address."""
        self._tile_mask = tile_mask
        tiles = (-(-self._shape[0] // 16), -(-self._shape[1] // 16))
        return None if tile_mask is None else address("tile_mask", tile_mask, tiles, np.bool_)

    def _rasterize(self, dynamic: DynamicSplats[Floats] | None, draw: bool, depth: bool) -> None:
        self._dynamic = dynamics_struct(dynamic)
        self._dynamic_arrays = dynamic
        self._drawn = False
        if draw:
            self.rgb = np.empty((3, *self._shape), np.float32)
            self.alpha = np.empty(self._shape, np.float32)
            self.depth = np.empty(self._shape, np.float32) if depth else None
        status = load().hgs_rasterize(
            ctypes.c_void_p(self._workspace),
            ctypes.byref(self._view),
            ctypes.byref(self._static),
            ctypes.byref(self._dynamic),
            self._threads,
            ctypes.byref(self._picture()) if draw else None,
        )
        check(status)
        self._drawn = draw

    def _picture(self) -> CPicture:
        depth = None if self.depth is None else self.depth.ctypes.data
        return CPicture(self.rgb.ctypes.data, self.alpha.ctypes.data, depth)

    def __del__(self) -> None:
        self.release()

    def release(self) -> None:
        """Let the next rendering use the workspace; nothing but the pictures is left afterwards."""
        if self._workspace is not None:
            workspace, self._workspace = self._workspace, None
            if len(_free_workspaces) < core_count():
                _free_workspaces.append(workspace)
            else:
                load().hgs_workspace_destroy(ctypes.c_void_p(workspace))

    def backward(
        self,
        grad_rgb: Floats,
        grad_alpha: Floats | None,
        grad_static: Mapping[str, Floats] | None,
        grad_dynamic: Mapping[str, Floats] | None,
        statistics: tuple[Floats, npt.NDArray[np.int32]] | None = None,
        grad_depth: Floats | None = None,
    ) -> None:
        """Differentiate the rendering with respect to the sets that are given somewhere to write to.

        Args:
            grad_rgb: [3, H, W] dL / d rgb.
            grad_alpha: [H, W] dL / d alpha, or None if that is zero.
            grad_static: parameter name -> array of its shape, overwritten; None leaves the statics out.
            grad_dynamic: the same for the dynamics.
            statistics: pull sums and counts of `hgs_core.render.ScreenStatistics`, added to.
            grad_depth: [H, W] dL / d depth, or None if that is zero.

        Raises:
            ValueError: an array of another shape or type, or a gradient of a depth that was not asked for.
            RuntimeError: `release` was called, or `redraw` has failed.
            MemoryError: not enough memory for the gradients of the tiles.
        """
        if self._workspace is None or not self._drawn:
            raise RuntimeError("backward after release, or after a rendering that failed or drew nothing")
        if grad_depth is not None and self.depth is None:
            raise ValueError("a gradient of the depth needs a rendering with depth=True")
        count = self._static.count + self._dynamic.count
        gathered = None
        if statistics is not None:
            gathered = CScreenStatistics(
                address("pull_sum", statistics[0], (count,)), address("count", statistics[1], (count,), np.int32)
            )
        gradient = CPicture(
            address("grad_rgb", grad_rgb, (3, *self._shape)),
            None if grad_alpha is None else address("grad_alpha", grad_alpha, self._shape),
            None if grad_depth is None else address("grad_depth", grad_depth, self._shape),
        )
        status = load().hgs_rasterize_backward(
            ctypes.c_void_p(self._workspace),
            ctypes.byref(self._static),
            ctypes.byref(self._dynamic),
            ctypes.byref(self._picture()),
            ctypes.byref(gradient),
            gradients_struct(CStaticGradients(), grad_static, self._static.count, STATIC_SHAPES),
            gradients_struct(
                CDynamicGradients(), grad_dynamic, self._dynamic.count, dynamic_shapes(self._dynamic.coefficients)
            ),
            None if gathered is None else ctypes.byref(gathered),
            self._threads,
        )
        check(status)

    def contributions(self) -> tuple[Floats, Floats]:
        """Return the sum over the pixels and the largest of every splat's weights, [N + M] each, statics first.

        Raises:
            RuntimeError: `release` was called.
            MemoryError: not enough memory for one number per splat and tile.
        """
        if self._workspace is None:
            raise RuntimeError("contributions after release")
        count = self._static.count + self._dynamic.count
        total, peak = np.empty(count, np.float32), np.empty(count, np.float32)
        places = [ctypes.c_void_p(array.ctypes.data) for array in (total, peak)]
        check(load().hgs_contributions(ctypes.c_void_p(self._workspace), self._threads, *places))
        return total, peak

    def measurements(self) -> Measurements:
        """Return where the time of the last calls went, and how much there was to do.

        Raises:
            RuntimeError: `release` was called, or the last rendering failed or drew nothing.
        """
        if self._workspace is None or not self._drawn:
            raise RuntimeError("measurements after release, or of a rendering that failed or drew nothing")
        found = CMeasurements()
        load().hgs_measure(ctypes.c_void_p(self._workspace), ctypes.byref(found))
        return Measurements(*(getattr(found, name) for name in Measurements._fields))
