"""LDR-FLIP, the difference seen when alternating two pictures (Andersson et al., HPG 2020).

The computation is that of the authors' package flip-evaluator, which is loaded when it is first needed.
"""

from __future__ import annotations

import math
from types import ModuleType

import numpy as np
from torch import Tensor

from hgs_core.base.errors import InputError

__all__ = ["PIXELS_PER_DEGREE", "flip", "require_flip"]

PIXELS_PER_DEGREE = 3840 * math.pi / 180
"""The paper's viewing conditions: 0.7 m from a display 0.7 m and 3840 pixels wide; 67.02."""


def require_flip() -> None:
    """Check that FLIP can be computed.

    Raises:
        InputError: the package is not installed; the message names the extra that has it.
    """
    _package()


def flip(image: Tensor, truth: Tensor) -> float:
    """Return the mean LDR-FLIP of two pictures [3, H, W] in [0, 1] (sRGB): 0 for equal pictures, at most 1.

    Raises:
        InputError: as `require_flip`.
    """
    planes = [np.ascontiguousarray(picture.permute(1, 2, 0).numpy(), np.float32) for picture in (truth, image)]
    errors, _, _ = _package().evaluate(
        *planes, "LDR", applyMagma=False, computeMeanError=False, parameters={"ppd": PIXELS_PER_DEGREE}
    )
    return float(np.mean(errors, dtype=np.float64))


def _package() -> ModuleType:
    try:
        import flip_evaluator
    except ImportError as error:
        raise InputError("--flip", "the package flip-evaluator is not installed", "pip install 'hgs[eval]'") from error
    return flip_evaluator  # type: ignore[no-any-return]
