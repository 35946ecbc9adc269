"""Triton for tests: compiled where there is a CUDA device, else its interpreter, made fast enough."""

from __future__ import annotations

import importlib.util
import os
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import torch

__all__ = ["DEVICE", "INSTALLED", "prepare"]

INSTALLED = importlib.util.find_spec("triton") is not None
DEVICE = "cuda" if torch.cuda.is_available() else "cpu"


def prepare() -> None:
    """Let the kernels run on the CPU if there is no CUDA device.

    Triton decides when it is imported whether it interprets; nothing else in the test suite imports it earlier. Its
    interpreter prepares `triton.language` anew at every call of every function of a kernel: here once. It also computes
    the values of masked lanes; numpy's warnings about these mean nothing. Its place in the grid is a global: one launch
    at a time, whereas a device takes them from any thread.
    """
    if DEVICE == "cuda" or os.environ.get("TRITON_INTERPRET") == "1":
        return
    os.environ["TRITON_INTERPRET"] = "1"
    from triton.runtime import interpreter

    patch: Callable[[Any], Any] = interpreter._patch_lang
    patched: set[int] = set()
    nothing = interpreter._LangPatchScope()

    def patch_once(function: Any) -> Any:
        if id(function.__globals__) not in patched:
            patched.add(id(function.__globals__))
            patch(function)
        return nothing

    launch = interpreter.GridExecutor.__call__

    one_launch = threading.Lock()

    def launch_quietly(self: Any, *args: Any, **kwargs: Any) -> None:
        with one_launch, np.errstate(all="ignore"):
            launch(self, *args, **kwargs)

    interpreter._patch_lang = patch_once
    interpreter.GridExecutor.__call__ = launch_quietly
