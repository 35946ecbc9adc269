"""Thread pools for slow work, separate from the threads of pages, scenes and readiness."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

__all__ = ["SlowWork"]

Result = TypeVar("Result")


class SlowWork:
    """A separate thread pool: waiting for one of its threads blocks nothing else."""

    def __init__(self, name: str, at_once: int) -> None:
        """Run up to `at_once` tasks in parallel; threads start on demand."""
        self._threads = ThreadPoolExecutor(at_once, name)

    async def run(self, work: Callable[..., Result], *arguments: object) -> Result:
        """Run a function in a thread of the pool, and return or raise its result."""
        return await asyncio.get_running_loop().run_in_executor(self._threads, work, *arguments)

    def close(self) -> None:
        """Start no further tasks."""
        self._threads.shutdown(wait=False, cancel_futures=True)
