"""How far a backend is from the float64 reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from hgs_core.bench.raster.workload import BACKGROUND, Workload
from hgs_core.render.rasterize import rasterize
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.loss import photometric_loss
from hgs_core.train.train_config import TrainConfig

__all__ = ["Errors", "errors"]


@dataclass(frozen=True)
class Errors:
    """Relative L2 errors: |x - truth| / |truth|, the norms over all elements."""

    image: float
    gradients: dict[str, float]  # "static.means" and so on, of every parameter array


def errors(workload: Workload, backends: Sequence[str]) -> dict[str, Errors]:
    """Compare the float32 picture and gradients of each backend with those of the reference in float64.

    All start from the same float32 parameters, and all differentiate with the same gradient of the picture: that of
    the training loss at the true picture. Were it computed from each picture anew, the sign of L1 would jump where a
    picture crosses the target, and the loss, not the rasterizer, would be measured.
    """
    static, dynamic = _leaves(workload, torch.float64)
    truth = _draw(workload, static, dynamic, "reference")
    picture = truth.detach().requires_grad_(True)
    (slope,) = torch.autograd.grad(photometric_loss(picture, workload.target.double(), TrainConfig().dssim), picture)
    upstream = slope.float()
    true_gradients = _gradients(truth, upstream.double(), static, dynamic)

    found = {}
    for backend in backends:
        static, dynamic = _leaves(workload, torch.float32)
        image = _draw(workload, static, dynamic, backend)
        gradients = _gradients(image, upstream, static, dynamic)
        found[backend] = Errors(
            _relative_l2(image, truth),
            {name: _relative_l2(gradient, true_gradients[name]) for name, gradient in gradients.items()},
        )
    return found


def _leaves(workload: Workload, dtype: torch.dtype) -> tuple[StaticSplats[Tensor], DynamicSplats[Tensor] | None]:
    static, dynamic = workload.static(dtype), workload.dynamic(dtype)

    def leaf(array: Tensor) -> Tensor:
        return array.detach().requires_grad_(True)

    return static.map(leaf), None if dynamic is None else dynamic.map(leaf)


def _draw(
    workload: Workload, static: StaticSplats[Tensor], dynamic: DynamicSplats[Tensor] | None, backend: str
) -> Tensor:
    return rasterize(static, dynamic, workload.camera, workload.scene.time, background=BACKGROUND, backend=backend).rgb


def _gradients(
    image: Tensor, upstream: Tensor, static: StaticSplats[Tensor], dynamic: DynamicSplats[Tensor] | None
) -> dict[str, Tensor]:
    image.backward(upstream)  # type: ignore[no-untyped-call]
    named = [(f"static.{name}", array) for name, array in static.items()]
    if dynamic is not None:
        named += [(f"dynamic.{name}", array) for name, array in dynamic.items()]
    return {name: torch.zeros_like(array) if array.grad is None else array.grad for name, array in named}


def _relative_l2(value: Tensor, truth: Tensor) -> float:
    truth = truth.detach()
    difference, size = (value.detach().double() - truth).norm(), truth.norm()
    return float(difference / size) if size > 0 else float(difference)
