"""Threads for what may take seconds, apart from those that pages, scenes and readiness share."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

__all__ = ["SlowWork"]

Result = TypeVar("Result")


class SlowWork:
    """A pool of its own: what waits for a thread of it keeps nobody else waiting."""

    def __init__(self, name: str, at_once: int) -> None:
        """Do so many things at once; threads start when they are needed."""
        self._threads = ThreadPoolExecutor(at_once, name)

    async def run(self, work: Callable[..., Result], *arguments: object) -> Result:
        """Do something in one of the threads, and return or raise what it does."""
        return await asyncio.get_running_loop().run_in_executor(self._threads, work, *arguments)

    def close(self) -> None:
        """Begin nothing more."""
        self._threads.shutdown(wait=False, cancel_futures=True)
