"""The processor's cores: how many a process may use, and a pool of threads for work on all of them."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from functools import lru_cache
from typing import TypeVar

from threadpoolctl import ThreadpoolController

from hgs_core.base.errors import InputError

__all__ = ["core_count", "core_pool", "watched"]

_REPORT_EVERY = 0.5  # seconds

K = TypeVar("K")
T = TypeVar("T")


def core_count() -> int:
    """Return the number of threads that a call uses by default: HGS_THREADS, or the cores that the process may use.

    Raises:
        InputError: HGS_THREADS is not a positive integer.
    """
    text = os.environ.get("HGS_THREADS", "")
    if text:
        if not text.isdecimal() or int(text) < 1:
            raise InputError("HGS_THREADS", f"{text!r} is not a positive integer")
        return int(text)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def core_pool(most: int | None = None) -> Iterator[ThreadPoolExecutor]:
    """A pool of as many threads as cores, or of `most`; numpy's matrix products keep to one thread meanwhile.

    Small products in many threads at once, each of which the BLAS library shares among all cores, wait for each other
    longer than they compute.

    Raises:
        InputError: as `core_count`.
    """
    cores = core_count()
    products = _libraries(len(sys.modules)).limit(limits=1, user_api="blas")
    with products, ThreadPoolExecutor(min(cores, most or cores)) as pool:
        yield pool


@lru_cache(maxsize=1)
def _libraries(_modules: int) -> ThreadpoolController:
    """Return the loaded libraries, sought again once further modules were imported: these bring them, in 1.5 ms."""
    return ThreadpoolController()


def watched(jobs: Mapping[K, Future[T]], report: Callable[[], None], unwanted: threading.Event) -> dict[K, T]:
    """Return the results of jobs in a pool; `report` is called every half second, and whenever a job ends.

    Raises:
        Exception: that of a job or of `report`; `unwanted` is set first, for the other jobs to end by.
    """
    pending: set[Future[T]] = set(jobs.values())
    try:
        while pending:
            finished, pending = wait(pending, _REPORT_EVERY, FIRST_COMPLETED)
            for job in finished:
                job.result()
            report()
    except BaseException:
        unwanted.set()
        raise
    return {key: job.result() for key, job in jobs.items()}
