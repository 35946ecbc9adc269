"""The use of the processor's cores: by torch, or by the compiled kernels."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import torch

from hgs_core.native import library

__all__ = ["one_torch_thread"]


@contextmanager
def one_torch_thread() -> Iterator[None]:
    """Keep torch to one thread while the compiled kernels use them all.

    Both pools at once oversubscribe the cores: small torch operations became a hundred times slower. One thread also
    fixes the order of torch's sums, so that the bits do not depend on the machine's cores.
    """
    threads = torch.get_num_threads()
    torch.set_num_threads(1 if library.available() else threads)
    try:
        yield
    finally:
        torch.set_num_threads(threads)
