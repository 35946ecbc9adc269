"""Adam over a struct of arrays whose rows come and go (Kingma and Ba, 2015)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import torch
from torch import Tensor

from hgs_core.native import library
from hgs_core.native.adam import adam_step
from hgs_core.render.triton.device import available
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["Adam", "adam_update"]

S = TypeVar("S", StaticSplats[Tensor], DynamicSplats[Tensor])

BETA1, BETA2, EPSILON = 0.9, 0.999, 1e-15


@dataclass
class Adam(Generic[S]):
    """The moments of one set of splats and the number of steps taken."""

    first: S
    second: S
    steps: int = 0

    @staticmethod
    def of(splats: S) -> Adam[S]:
        """Return an optimiser that has seen no gradient of `splats` yet."""
        return Adam(splats.map(torch.zeros_like), splats.map(torch.zeros_like))

    def step(self, splats: S, rates: Mapping[str, float | Tensor]) -> None:
        """Update `splats` in place from their `.grad`; arrays without a gradient stay.

        Args:
            splats: the parameters.
            rates: a step size per field; or a tensor of them, one for every row or part of a row (`adam_update`).
        """
        self.steps += 1
        with torch.no_grad():
            for name, parameter in splats.items():
                if parameter.grad is None or len(parameter) == 0:
                    continue
                first, second = getattr(self.first, name), getattr(self.second, name)
                adam_update(parameter, parameter.grad, first, second, rates[name], self.steps)
                parameter.grad = None

    def to(self, device: torch.device) -> Adam[S]:
        """Return it with its moments on a device."""
        return Adam(self.first.map(lambda a: a.to(device)), self.second.map(lambda a: a.to(device)), self.steps)

    def select(self, rows: Tensor, added: int) -> None:
        """Keep the moments of `rows` and append `added` rows of zeros."""
        self.first = _with_zeros(self.first, rows, added)
        self.second = _with_zeros(self.second, rows, added)

    def state(self) -> dict[str, Any]:
        """Return plain tensors for a checkpoint."""
        return {"first": dict(self.first.items()), "second": dict(self.second.items()), "steps": self.steps}


def adam_update(
    parameter: Tensor, gradient: Tensor, first: Tensor, second: Tensor, rate: float | Tensor, step: int
) -> None:
    """Change one array in place by its `step`-th Adam update (from 1); its moments follow.

    The rate is one step size, or a tensor of the parameter's shape but for last dimensions of 1, over which it is the
    same. Float32 arrays on the CPU use the compiled kernel where there is one, those on a CUDA device the Triton one.

    Raises:
        ValueError: rates of another shape.
    """
    factors, step_size = (_factors(rate, parameter), 1.0) if isinstance(rate, Tensor) else (None, rate)
    if parameter.device.type == "cpu" and parameter.dtype == torch.float32 and library.available():
        adam_step(
            parameter.detach().numpy(),
            gradient.contiguous().numpy(),
            first.numpy(),
            second.numpy(),
            learning_rate=step_size,
            beta1=BETA1,
            beta2=BETA2,
            epsilon=EPSILON,
            step=step,
            factors=None if factors is None else factors.numpy(),
        )
        return
    if available(parameter):
        from hgs_core.train.triton.adam import adam_step as adam_step_triton

        adam_step_triton(
            parameter, gradient.contiguous(), first, second, step_size, step,
            beta1=BETA1, beta2=BETA2, epsilon=EPSILON, factors=factors,
        )  # fmt: skip
        return
    first.mul_(BETA1).add_(gradient, alpha=1 - BETA1)
    second.mul_(BETA2).addcmul_(gradient, gradient, value=1 - BETA2)
    scale = (second / (1 - BETA2**step)).sqrt_().add_(EPSILON)
    moved = first * rate if isinstance(rate, Tensor) else first
    parameter.addcdiv_(moved, scale, value=-step_size / (1 - BETA1**step))


def _factors(rates: Tensor, parameter: Tensor) -> Tensor:
    """Return rates as the kernels take them: one after the other, each for equally many values of the parameter."""
    dimensions = parameter.dim()
    if not any(rates.shape == (*parameter.shape[:k], *[1] * (dimensions - k)) for k in range(dimensions + 1)):
        raise ValueError(f"rates of shape {tuple(rates.shape)} are not for rows of {tuple(parameter.shape)}")
    return rates.to(parameter.dtype).reshape(-1)


def _with_zeros(splats: S, rows: Tensor, added: int) -> S:
    return splats.map(lambda array: torch.cat([array[rows], array.new_zeros((added, *array.shape[1:]))]))
