"""The cores of the processor: the number of threads, and pools in which matrix products take one."""

from __future__ import annotations

import numpy as np
import pytest
from threadpoolctl import threadpool_info

from hgs_core.base.cores import core_count, core_pool
from hgs_core.base.errors import InputError


def blas_threads() -> set[int]:
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def test_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HGS_THREADS", "3")
    assert core_count() == 3
    monkeypatch.setenv("HGS_THREADS", "many")
    with pytest.raises(InputError, match="HGS_THREADS: 'many' is not a positive integer"):
        core_count()
    monkeypatch.delenv("HGS_THREADS")
    assert core_count() >= 1


def test_matrix_products_in_a_pool_take_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HGS_THREADS", "3")
    np.ones((4, 4)) @ np.ones((4, 4))
    before = blas_threads()
    with core_pool() as pool:
        assert pool.submit(blas_threads).result() == {1}
        assert pool._max_workers == 3
    assert blas_threads() == before
