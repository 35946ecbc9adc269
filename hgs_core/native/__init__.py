"""The C++17 CPU kernels and their bindings: rasterization, the training loss and Adam, on numpy arrays."""

from hgs_core.native.library import available

__all__ = ["available"]
