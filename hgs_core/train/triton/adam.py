"""Adam on tensors of the device that the Triton kernels run on."""

from __future__ import annotations

import math

import triton
from torch import Tensor

from hgs_core.render.triton.device import launching_on
from hgs_core.train.triton.kernels.adam import adam

__all__ = ["adam_step"]

_BLOCK = 1024


def adam_step(
    parameters: Tensor,
    gradients: Tensor,
    first_moments: Tensor,
    second_moments: Tensor,
    learning_rate: float,
    step: int,
    *,
    beta1: float,
    beta2: float,
    epsilon: float,
    factors: Tensor | None = None,
) -> None:
    """Take one step of Adam as `hgs_core.native.adam.adam_step` does, on float32 tensors of one CUDA device."""
    count = parameters.numel()
    span = 1 if factors is None else count // factors.numel()
    rate, inverse_root = learning_rate / (1 - beta1**step), 1 / math.sqrt(1 - beta2**step)
    with launching_on(parameters.device):
        adam[(triton.cdiv(count, _BLOCK),)](
            parameters, gradients, first_moments, second_moments, factors, rate, inverse_root, count,
            SPAN=span, BETA1=beta1, BETA2=beta2, EPSILON=epsilon, BLOCK=_BLOCK,
        )  # fmt: skip
