"""How far results may be from their float64 references: one table for all numerical tests.

Both terms are relative: rtol to the value itself, atol to the largest value of the array it belongs to.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["TOLERANCES", "assert_close"]

TOLERANCES: dict[str, tuple[float, float]] = {
    "float32": (1e-4, 2e-5),
    "float64": (1e-9, 1e-11),
}


def assert_close(actual: npt.ArrayLike, reference: npt.ArrayLike, name: str = "") -> None:
    """Assert that `actual` agrees with `reference` as well as its own type allows."""
    measured = np.asarray(actual)
    truth: npt.NDArray[Any] = np.asarray(reference, dtype=np.float64)
    rtol, atol = TOLERANCES[measured.dtype.name]
    largest = float(np.abs(truth).max(initial=0.0))
    np.testing.assert_allclose(measured, truth, rtol=rtol, atol=atol * largest, err_msg=name)
