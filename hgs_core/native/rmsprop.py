"""RMSprop on numpy arrays."""

from __future__ import annotations

import ctypes

import numpy as np
import numpy.typing as npt

from hgs_core.base.cores import core_count
from hgs_core.native.kernel_arrays import Floats, address
from hgs_core.native.library import check, load

__all__ = ["rmsprop_step"]


def rmsprop_step(
    parameters: Floats,
    gradients: Floats,
    moments: Floats,
    learning_rate: float,
    correction: float,
    *,
    beta: float = 0.999,
    epsilon: float = 1e-15,
    factors: Floats | None = None,
    rows: npt.NDArray[np.int64] | None = None,
    decays: Floats | None = None,
    threads: int | None = None,
) -> None:
    """Take one step of RMSprop with bias correction (Tieleman and Hinton, 2012), in place.

    Args:
        parameters: [N, ...] float32, contiguous; changed.
        gradients: [R, ...] of all rows, or of those that `rows` names.
        moments: the shape of `parameters`, zero before the first step: mean squares of the gradients; changed.
        learning_rate: step size.
        correction: 1 - beta^n for the n-th step.
        beta: decay of the moments.
        epsilon: added to the root of the corrected moment.
        factors: [F] of the step size, each for `gradients.size` / F values in turn; None: 1 for all.
        rows: [R] of 0 to N - 1, none twice; None: all of them.
        decays: [R] what is left of the moments of these rows; None: `beta`.
        threads: default `core_count()`.

    Raises:
        ValueError: an array of another shape or type, factors that do not divide the values, a row that is not there,
            or a correction that is not positive.
        RuntimeError: no compiled library.
    """
    if correction <= 0:
        raise ValueError(f"the correction of a step is positive, got {correction}")
    count = len(parameters) if rows is None else len(rows)
    shape = (count, *parameters.shape[1:])
    places = [
        ctypes.c_void_p(address(name, array, expected))
        for name, array, expected in (
            ("parameters", parameters, parameters.shape),
            ("gradients", gradients, shape),
            ("moments", moments, parameters.shape),
        )
    ]
    rows_at = decays_at = factors_at = ctypes.c_void_p(None)
    if rows is not None:
        rows_at = ctypes.c_void_p(address("rows", rows, (count,), np.int64))
        if count and not (rows.min() >= 0 and rows.max() < len(parameters)):
            raise ValueError(f"rows must be from 0 to {len(parameters) - 1}, got {rows.min()} to {rows.max()}")
    if decays is not None:
        decays_at = ctypes.c_void_p(address("decays", decays, (count,)))
    span = 1
    if factors is not None and gradients.size:
        if factors.ndim != 1 or factors.size == 0 or gradients.size % factors.size:
            raise ValueError(f"factors must divide the {gradients.size} values, got shape {factors.shape}")
        factors_at = ctypes.c_void_p(address("factors", factors, factors.shape))
        span = gradients.size // factors.size
    status = load().hgs_rmsprop(
        ctypes.c_int64(count),
        ctypes.c_int64(gradients.size // count if count else 0),
        rows_at,
        *places,
        decays_at,
        ctypes.c_double(beta),
        factors_at,
        ctypes.c_int64(span),
        ctypes.c_double(learning_rate),
        ctypes.c_double(correction),
        ctypes.c_double(epsilon),
        threads or core_count(),
    )
    check(status)
