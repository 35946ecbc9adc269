"""RMSprop on tensors of the device that the Triton kernels run on."""

from __future__ import annotations

import math

import triton
from torch import Tensor

from hgs_core.render.triton.device import launching_on
from hgs_core.train.triton.kernels.rmsprop import rmsprop

__all__ = ["rmsprop_step"]

_BLOCK = 1024


def rmsprop_step(
    parameters: Tensor,
    gradients: Tensor,
    moments: Tensor,
    learning_rate: float,
    correction: float,
    *,
    beta: float,
    epsilon: float,
    factors: Tensor | None = None,
    rows: Tensor | None = None,
    decays: Tensor | None = None,
) -> None:
    """Take one step as `hgs_core.native.rmsprop.rmsprop_step` does, on float32 tensors of one CUDA device."""
    count = gradients.numel()
    if count == 0:
        return
    width = count // len(gradients)
    span = 1 if factors is None else count // factors.numel()
    with launching_on(parameters.device):
        rmsprop[(triton.cdiv(count, _BLOCK),)](
            parameters,
            gradients,
            moments,
            factors,
            rows,
            decays,
            learning_rate,
            1 / math.sqrt(correction),
            count,
            SPAN=span,
            WIDTH=width,
            BETA=beta,
            EPSILON=epsilon,
            BLOCK=_BLOCK,
        )
