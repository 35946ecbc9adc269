"""Which backend draws."""

from __future__ import annotations

from typing import Literal

import torch
from torch import Tensor

from hgs_core.errors import InputError
from hgs_core.native import library
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["Backend", "choose_backend"]

Backend = Literal["cpu", "reference"]


def choose_backend(
    name: str, static: StaticSplats[Tensor] | None, dynamic: DynamicSplats[Tensor] | None = None
) -> Backend:
    """Return the backend of that name; for "auto", "cpu" where it is built and the splats are float32 on the CPU.

    Raises:
        InputError: an unknown name.
    """
    if name == "auto":
        colours = [splats.rgb for splats in (static, dynamic) if splats is not None]
        fits = all(array.device.type == "cpu" and array.dtype == torch.float32 for array in colours)
        return "cpu" if fits and library.available() else "reference"
    if name == "cpu":
        return "cpu"
    if name == "reference":
        return "reference"
    raise InputError("backend", f"unknown backend {name!r}", "use auto, cpu or reference")
