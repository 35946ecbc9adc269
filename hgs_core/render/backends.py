"""Which backend draws."""

from __future__ import annotations

from typing import Literal

import torch
from torch import Tensor

from hgs_core.base.errors import InputError
from hgs_core.native import library
from hgs_core.render.triton.device import available, require_device
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["Backend", "choose_backend", "training_device"]

Backend = Literal["cpu", "triton", "reference"]


def choose_backend(
    name: str, static: StaticSplats[Tensor] | None, dynamic: DynamicSplats[Tensor] | None = None
) -> Backend:
    """Return the backend of that name.

    For "auto" that is "cpu" where it is built and the splats are float32 on the CPU, "triton" where it is installed and
    they are float32 on a CUDA device, and else "reference".

    Raises:
        InputError: an unknown name, or "triton" without the package or without a CUDA device.
    """
    colours = [splats.rgb for splats in (static, dynamic) if splats is not None]
    if name == "auto":
        if colours and all(available(array) for array in colours):
            return "triton"
        fits = all(array.device.type == "cpu" and array.dtype == torch.float32 for array in colours)
        return "cpu" if fits and library.available() else "reference"
    if name == "cpu":
        return "cpu"
    if name == "triton":
        require_device(colours[0] if colours else None)
        return "triton"
    if name == "reference":
        return "reference"
    raise InputError("backend", f"unknown backend {name!r}", "use auto, cpu, triton or reference")


def training_device(backend: str) -> torch.device:
    """Return where a training with this backend keeps its tensors.

    Raises:
        InputError: "triton" without the package or without a CUDA device.
    """
    return require_device() if backend == "triton" else torch.device("cpu")
