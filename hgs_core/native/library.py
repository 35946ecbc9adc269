"""Finding and loading the compiled kernels.

The build makes one shared library per instruction set: `hgs_native_v2`, `_v3` and `_v4` for the x86-64
microarchitecture levels, `hgs_native_generic` elsewhere. The best one that the processor supports is loaded once per
process.

Environment:
    HGS_NATIVE_ISA: "v2", "v3", "v4" or "generic" forces one library, "none" none at all.
    HGS_THREADS: threads per call; the default is the number of processors this process may run on.
"""

from __future__ import annotations

import ctypes
import functools
import os
import platform
import sys
import warnings
from pathlib import Path

import hgs_core.native
from hgs_core.base.errors import InputError

__all__ = ["available", "check", "instruction_set", "load", "supported"]

ABI_VERSION = 12  # HGS_ABI_VERSION of src/hgs_native.h
LEVELS = ("v2", "v3", "v4")
SUFFIX = ".dylib" if sys.platform == "darwin" else ".so"


def available() -> bool:
    """Return whether the kernels can be used; warn once per process if they were not built."""
    return _loaded() is not None


def load() -> ctypes.CDLL:
    """Return the loaded library.

    Raises:
        RuntimeError: there is none; see `available`.
        InputError: HGS_NATIVE_ISA names a library that does not exist or that this processor cannot run.
    """
    loaded = _loaded()
    if loaded is None:
        raise RuntimeError("the native kernels are not available: install a C++17 compiler and reinstall hgs")
    return loaded[1]


def instruction_set() -> str | None:
    """Return the instruction set of the loaded library: "v2", "v3", "v4", "generic", or None without a library."""
    loaded = _loaded()
    return None if loaded is None else loaded[0]


def supported() -> list[str]:
    """Return the instruction sets that were built and that this processor can run, the best last."""
    return _supported(_find())


def check(status: int) -> None:
    """Raise the error of a status code of the library.

    Raises:
        MemoryError: the kernels could not allocate their buffers.
        FloatingPointError: a parameter of a splat is NaN or infinite, or a colour beyond 1e18.
        RuntimeError: any other failure, in the library's words.
    """
    if status == 0:
        return
    message = load().hgs_status_message(status).decode()
    raise {1: MemoryError, 4: FloatingPointError}.get(status, RuntimeError)(message)


@functools.cache
def _loaded() -> tuple[str, ctypes.CDLL] | None:
    """Load the best library once."""
    found = _find()
    forced = os.environ.get("HGS_NATIVE_ISA", "")
    if forced == "none":
        return None
    if forced and forced not in found:
        raise InputError("HGS_NATIVE_ISA", f"there is no library for {forced!r}", f"use one of {sorted(found)}")
    if not found:
        warnings.warn(
            "hgs was built without its C++ kernels: rendering and training on the CPU fall back to torch and are "
            "far slower; install a C++17 compiler and reinstall hgs",
            RuntimeWarning,
            stacklevel=3,
        )
        return None
    supported = _supported(found)
    if forced and forced not in supported:
        raise InputError("HGS_NATIVE_ISA", f"this processor cannot run {forced!r}", f"use one of {supported}")
    if not supported:
        return None
    isa = forced or supported[-1]
    library = ctypes.CDLL(str(found[isa]))
    version = library.hgs_abi_version()
    if version != ABI_VERSION:
        raise RuntimeError(f"{found[isa].name} has ABI {version}, this code needs {ABI_VERSION}: reinstall hgs")
    library.hgs_status_message.restype = ctypes.c_char_p
    return isa, library


def _find() -> dict[str, Path]:
    """Return instruction set -> library, over every folder of the package (an editable install has two)."""
    prefix = "hgs_native_"
    return {
        path.name.removesuffix(SUFFIX).removeprefix(prefix): path
        for folder in reversed(list(hgs_core.native.__path__))
        for path in sorted(Path(folder).glob(f"{prefix}*{SUFFIX}"))
    }


def _supported(found: dict[str, Path]) -> list[str]:
    """Return the libraries of `found` that this processor can run, the best last."""
    if "generic" in found:
        return ["generic"]
    if platform.machine().lower() not in ("x86_64", "amd64") or "v2" not in found:
        return []
    # The v2 library asks the processor, which also covers what the operating system has switched off.
    level = int(ctypes.CDLL(str(found["v2"])).hgs_cpu_level())
    return [name for name in LEVELS if name in found and int(name[1:]) <= level]
