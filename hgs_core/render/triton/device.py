"""Where the Triton kernels run, if they can run at all; free of Triton itself."""

from __future__ import annotations

import importlib.util
import os
from contextlib import AbstractContextManager, nullcontext

import torch
from torch import Tensor

from hgs_core.base.errors import InputError

__all__ = ["available", "launching_on", "require_device"]


def available(like: Tensor) -> bool:
    """Return whether the kernels run where this tensor lies, in its type."""
    fits = like.device.type == "cuda" and like.dtype == torch.float32
    return fits and importlib.util.find_spec("triton") is not None


def require_device(like: Tensor | None = None) -> torch.device:
    """Return the device that the kernels run on: the CUDA device of a tensor that lies on one, else the current one.

    Raises:
        InputError: Triton is not installed, or there is no CUDA device.
    """
    if importlib.util.find_spec("triton") is None:
        raise InputError("backend", "triton needs the package triton, which is not installed", "install hgs[gpu]")
    if like is not None and like.device.type == "cuda":
        return like.device
    if os.environ.get("TRITON_INTERPRET") == "1":  # Triton's interpreter, on the CPU: slow; for tests
        return torch.device("cpu")
    if not torch.cuda.is_available():
        raise InputError(
            "backend",
            f"triton needs a CUDA device and torch {torch.__version__} sees none",
            "install a torch with CUDA and the NVIDIA driver, or use cpu",
        )
    return torch.device("cuda", torch.cuda.current_device())


def launching_on(device: torch.device) -> AbstractContextManager[object]:
    """Make a device the one that kernels are launched on."""
    return torch.cuda.device(device) if device.type == "cuda" else nullcontext()
