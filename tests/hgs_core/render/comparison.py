"""Rendering and differentiating with one backend, and how far the results are from another's."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import pytest
import torch
from torch import Tensor

from hgs_core.native import library
from hgs_core.render.cpu import rasterize_cpu
from hgs_core.render.reference import rasterize_reference
from hgs_core.render.types import Render, ScreenStatistics, View
from hgs_core.scene import DynamicSplats, StaticSplats
from tests.hgs_core.render.hard_cases import HardCase
from tests.tolerances import assert_close

Backend = Callable[[StaticSplats[Tensor] | None, DynamicSplats[Tensor] | None, View], Render]

BACKENDS: dict[str, Backend] = {"cpu": rasterize_cpu, "reference": rasterize_reference}

# Parametrises a test with every backend that is there.
every_backend = pytest.mark.parametrize(
    "backend",
    [
        pytest.param("cpu", marks=pytest.mark.skipif(not library.instruction_set(), reason="no C++ kernels")),
        "reference",
    ],
)

_SMALLEST = 1e-20  # norms below this count as this: float32 has no digits left when they are squared


@dataclass
class Result:
    render: Render
    static: StaticSplats[Tensor] | None  # leaves that have their gradients
    dynamic: DynamicSplats[Tensor] | None
    statistics: ScreenStatistics

    def pictures(self) -> dict[str, Tensor]:
        """Name -> drawn picture."""
        return {name: image.detach() for name, image in self.render._asdict().items() if image is not None}

    def gradients(self) -> dict[str, Tensor]:
        """Name -> gradient of every parameter that got one."""
        sets = {"static": self.static, "dynamic": self.dynamic}
        return {
            f"{kind} {name}": array.grad
            for kind, splats in sets.items()
            if splats is not None
            for name, array in splats.items()
            if array.grad is not None
        }


def differentiate(
    backend: str,
    dtype: torch.dtype,
    static: StaticSplats[Tensor] | None,
    dynamic: DynamicSplats[Tensor] | None,
    view: View,
) -> Result:
    """Render the float32 values of the splats in `dtype`, and differentiate a random weighting of all pictures."""

    def leaf(array: Tensor) -> Tensor:
        return array.detach().float().to(dtype, copy=True).requires_grad_()

    static = static.map(leaf) if static is not None else None
    dynamic = dynamic.map(leaf) if dynamic is not None else None
    statistics = ScreenStatistics.zeros(len(static or ()) + len(dynamic or ()))
    render = BACKENDS[backend](static, dynamic, dataclasses.replace(view, statistics=statistics))
    generator = torch.Generator().manual_seed(0)
    shape = (5, view.camera.height, view.camera.width)
    weights = torch.randn(shape, generator=generator, dtype=torch.float64).to(dtype)
    loss = (render.rgb * weights[:3]).sum() + (render.alpha * weights[3]).sum()
    if render.depth is not None:
        loss = loss + (render.depth * weights[4]).sum()
    if loss.requires_grad:
        loss.backward()
    return Result(render, static, dynamic, statistics)


def relative_error(actual: Tensor, truth: Tensor) -> float:
    """Relative L2 error; a NaN counts as infinite."""
    error = torch.linalg.vector_norm(actual.double() - truth.double())
    relative = float(error / torch.linalg.vector_norm(truth.double()).clamp_min(_SMALLEST))
    return relative if relative == relative else float("inf")


def check_case(case: HardCase, backend: str, truth: Result | None = None) -> None:
    """Assert that a backend in float32 keeps a hard case's bounds; `truth`: the reference in float64, if at hand."""
    truth = truth or differentiate("reference", torch.float64, case.static, case.dynamic, case.view)
    result = differentiate(backend, torch.float32, case.static, case.dynamic, case.view)
    for kind, image in truth.pictures().items():
        assert relative_error(result.pictures()[kind], image) <= case.image, kind
    gradients = result.gradients()
    for parameter, gradient in truth.gradients().items():
        assert relative_error(gradients[parameter], gradient) <= case.gradient, parameter


def compare(
    static: StaticSplats[Tensor] | None,
    dynamic: DynamicSplats[Tensor] | None,
    view: View,
    backend: str = "cpu",
) -> Result:
    """Assert that a backend in float32 agrees with the reference in float64: pictures, gradients and statistics."""
    truth = differentiate("reference", torch.float64, static, dynamic, view)
    fast = differentiate(backend, torch.float32, static, dynamic, view)
    assert fast.pictures().keys() == truth.pictures().keys()
    for name, image in truth.pictures().items():
        assert_close(fast.pictures()[name].numpy(), image.numpy(), name)
    gradients = fast.gradients()
    for name, gradient in truth.gradients().items():
        assert_close(gradients.pop(name).numpy(), gradient.numpy(), name)
    assert not any(gradient.any() for gradient in gradients.values())
    assert_close(fast.statistics.pull_sum, truth.statistics.pull_sum, "pull_sum")
    assert (fast.statistics.count == truth.statistics.count).all()
    return fast
