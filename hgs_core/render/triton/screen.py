"""Both sets on the screen: the result of projection, kept on the device for later passes."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import torch
import triton
from torch import Tensor

from hgs_core.render.constants import FRUSTUM_MARGIN
from hgs_core.render.magnification import magnification
from hgs_core.render.triton.kernels import constants
from hgs_core.render.triton.kernels.projection_forward import project_dynamics, project_statics
from hgs_core.render.types import View
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["Screen", "project", "row_blocks"]

_BLOCK = 128  # splats of a program that has one lane per splat


@dataclass(frozen=True)
class Screen:
    """K = N + M splats, statics first; only the rows with a finite depth are in use, but for `depths`."""

    statics: int  # N
    camera: Tensor  # [28] float64, as `kernels.constants` lists them
    splats: Tensor  # [K, 8] float32, what compositing reads
    places: Tensor  # [K, 4] float64
    ellipses: Tensor  # [K, 8] float32
    boxes: Tensor  # [K, 4] int32, first and last column and row of pixels that the ellipse can reach
    depths: Tensor  # [K] float32, camera-space z; infinity: not drawn
    tally: Tensor  # [3] int64: blocks with a refused parameter; later also entries of statics and of dynamics


def row_blocks(rows: int) -> tuple[tuple[int], dict[str, Any]]:
    """Return the grid and the options of a kernel with one lane per row."""
    return (triton.cdiv(rows, _BLOCK),), {"BLOCK": _BLOCK, "num_warps": 4}


def project(
    static: StaticSplats[Tensor] | None, dynamic: DynamicSplats[Tensor] | None, view: View, device: torch.device
) -> Screen:
    """Project contiguous float32 splats on `device`."""
    n, m = len(static or ()), len(dynamic or ())

    def empty(width: int, dtype: torch.dtype) -> Tensor:
        return torch.empty((n + m, width), dtype=dtype, device=device)

    screen = Screen(
        n,
        _camera_tensor(view, device),
        empty(constants.SPLAT.value, torch.float32),
        empty(constants.PLACE.value, torch.float64),
        empty(constants.ELLIPSE.value, torch.float32),
        empty(4, torch.int32),
        torch.full((n + m,), torch.inf, device=device),
        torch.zeros(3, dtype=torch.int64, device=device),
    )
    outputs = [getattr(screen, field.name) for field in dataclasses.fields(screen)[1:]]
    if static is not None and n:
        grid, options = row_blocks(n)
        inputs = [array for _, array in static.items()]
        project_statics[grid](*inputs, n, *outputs, ANTIALIASED=view.antialiased, **options)
    if dynamic is not None and m:
        grid, options = row_blocks(m)
        inputs = [array for _, array in dynamic.items()]
        coefficients = dynamic.motion.shape[1]
        project_dynamics[grid](
            *inputs, m, n, *outputs, COEFFICIENTS=coefficients, ANTIALIASED=view.antialiased, **options
        )
    return screen


def _camera_tensor(view: View, device: torch.device) -> Tensor:
    c = view.camera
    pose = c.world_to_camera
    margin_x, margin_y = FRUSTUM_MARGIN * 0.5 * c.width / c.fx, FRUSTUM_MARGIN * 0.5 * c.height / c.fy
    values = [
        *pose[:3, :3].flatten().tolist(),
        *pose[:3, 3].tolist(),
        c.fx,
        c.fy,
        c.cx,
        c.cy,
        c.near,
        -c.cx / c.fx - margin_x,
        (c.width - c.cx) / c.fx + margin_x,
        -c.cy / c.fy - margin_y,
        (c.height - c.cy) / c.fy + margin_y,
        c.width,
        c.height,
        view.time,
        *magnification(c, view.rig),
    ]
    assert len(values) == constants.CAMERA_LENGTH
    return torch.tensor(values, dtype=torch.float64, device=device)
