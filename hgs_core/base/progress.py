"""How long-running stages tell the world how far they are."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

__all__ = ["Progress", "ProgressCallback", "StageStopped", "silent"]


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
    """Raised by a progress callback to stop a stage; the stage saves what it can resume from and re-raises."""


def silent(progress: Progress) -> None:
    """Ignore a report."""
