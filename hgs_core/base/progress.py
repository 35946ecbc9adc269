"""How long-running stages tell the world how far they are."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

__all__ = ["Progress", "ProgressCallback", "StageStopped", "interruptible", "silent", "stop_if_interruptible"]

_HERE = threading.local()


@dataclass(frozen=True)
class Progress:
    """One report of a stage: `done` of `total` units, with any figures worth showing (loss, psnr, splats)."""

    stage: str
    done: int
    total: int
    figures: Mapping[str, float] = field(default_factory=dict)


ProgressCallback = Callable[[Progress], None]
"""Called often and synchronously; it must be cheap. It may raise `StageStopped` to end the stage."""


class StageStopped(Exception):  # noqa: N818 - control flow, not an error
    """A request to stop, raised by a progress callback; the stage saves its checkpoint and re-raises."""


def silent(progress: Progress) -> None:
    """Ignore a report."""


@contextmanager
def interruptible() -> Iterator[None]:
    """Let a stop come between any two instructions of this thread, and not only where progress is reported.

    For work that takes long and has nothing in memory that must be saved: what it writes appears whole or not at all.
    """
    _HERE.depth = getattr(_HERE, "depth", 0) + 1
    try:
        yield
    finally:
        _HERE.depth -= 1


def stop_if_interruptible() -> None:
    """Stop this thread's work, for handlers of signals; elsewhere the next report of progress does.

    Raises:
        StageStopped: the thread is inside `interruptible`.
    """
    if getattr(_HERE, "depth", 0):
        raise StageStopped
