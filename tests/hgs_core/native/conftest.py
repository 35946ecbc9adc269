"""The kernels' tests need the kernels."""

from __future__ import annotations

import pytest

from hgs_core.native import library


@pytest.fixture(autouse=True)
def kernels() -> None:
    if not library.instruction_set():
        pytest.skip("hgs was built without its C++ kernels")
