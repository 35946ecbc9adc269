"""Adam on numpy arrays."""

from __future__ import annotations

import ctypes

from hgs_core.native.arrays import Floats, address
from hgs_core.native.library import check, load, thread_count

__all__ = ["adam_step"]


def adam_step(
    parameters: Floats,
    gradients: Floats,
    first_moments: Floats,
    second_moments: Floats,
    learning_rate: float,
    step: int,
    *,
    beta1: float = 0.9,
    beta2: float = 0.999,
    epsilon: float = 1e-15,
    factors: Floats | None = None,
    threads: int | None = None,
) -> None:
    """Take one step of Adam with bias correction (Kingma and Ba 2015, algorithm 1), in place.

    Args:
        parameters: any shape, float32, contiguous; changed.
        gradients: same shape.
        first_moments: same shape, zero before the first step; changed.
        second_moments: same shape, zero before the first step; changed.
        learning_rate: step size.
        step: number of this step, 1 for the first.
        beta1: decay of the first moments.
        beta2: decay of the second moments.
        epsilon: added to the root of the corrected second moment.
        factors: [F] of the step size, each for `parameters.size` / F values in turn; None: 1 for all.
        threads: default `thread_count()`.

    Raises:
        ValueError: an array of another shape or type, factors that do not divide the values, or a step below 1.
        RuntimeError: no compiled library.
    """
    if step < 1:
        raise ValueError(f"step counts from 1, got {step}")
    arrays = {
        "parameters": parameters,
        "gradients": gradients,
        "first_moments": first_moments,
        "second_moments": second_moments,
    }
    places = [ctypes.c_void_p(address(name, array, parameters.shape)) for name, array in arrays.items()]
    factors_at, span = ctypes.c_void_p(None), 1
    if factors is not None and parameters.size:
        if factors.ndim != 1 or factors.size == 0 or parameters.size % factors.size:
            raise ValueError(f"factors must divide the {parameters.size} values, got shape {factors.shape}")
        factors_at = ctypes.c_void_p(address("factors", factors, factors.shape))
        span = parameters.size // factors.size
    numbers = [ctypes.c_double(value) for value in (learning_rate, beta1, beta2, epsilon)]
    status = load().hgs_adam(
        ctypes.c_int64(parameters.size), *places, factors_at, ctypes.c_int64(span), *numbers, ctypes.c_int64(step),
        threads or thread_count(),
    )  # fmt: skip
    check(status)
