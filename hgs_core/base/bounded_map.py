"""A map over a pool of threads that holds few items at a time."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

from hgs_core.base.cores import core_count

__all__ = ["bounded_map"]

T = TypeVar("T")
R = TypeVar("R")


def bounded_map(
    pool: ThreadPoolExecutor, function: Callable[[T], R], items: Iterable[T], ahead: int | None = None
) -> Iterator[R]:
    """Yield `function` of every item, in order; an item is taken from `items` once fewer than `ahead` are in the pool.

    By default that is one more than there are cores.

    `ThreadPoolExecutor.map` takes all items at once, which for pictures are more than memory holds.

    Raises:
        Exception: that of `items` or `function`, at the item's turn; what has not begun by then never begins.
    """
    waiting: deque[Future[R]] = deque()
    most = core_count() + 1 if ahead is None else ahead
    try:
        for item in items:
            if len(waiting) >= most:
                yield waiting.popleft().result()
            waiting.append(pool.submit(function, item))
        while waiting:
            yield waiting.popleft().result()
    finally:
        for future in waiting:
            future.cancel()
