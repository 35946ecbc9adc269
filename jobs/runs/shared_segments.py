"""The segments of a run, made by several workers at once: the one that has the job, and others that help.

A segment is claimed by a file lock, which the kernel frees when its process dies: whoever comes next goes on from its
checkpoint; machines that share no folder claim and exchange segments through the store
(`jobs.runs.stored_segments`). After every segment the scene, as far as it has no gap, is published again.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Protocol

from hgs_core.base.progress import Progress, ProgressCallback

__all__ = ["MADE", "SEGMENTS", "Exchange", "Segments", "help_with_segment", "make_segments"]

SEGMENTS, MADE = "segments", "made"  # figures of a training: how many segments there are, and how many are made
LOOK = 0.5  # seconds between two looks whether others have made theirs


class Segments(Protocol):
    """A pipeline's work for one segment: `hgs_core.runs.by_segment`."""

    def segment_count(self, run: Path) -> int: ...  # noqa: D102
    def made(self, run: Path, number: int) -> bool: ...  # noqa: D102
    def make_segment(self, run: Path, number: int, progress: ProgressCallback) -> None: ...  # noqa: D102
    def assemble(self, run: Path) -> int: ...  # noqa: D102
    def finish(self, run: Path, progress: ProgressCallback) -> None: ...  # noqa: D102


class Exchange(Protocol):
    """The coordination of processes that make segments of one run."""

    def claimed(self, number: int, meanwhile: Callable[[], object]) -> AbstractContextManager[bool]:
        """Claim a segment for the block, which learns whether that was possible; `meanwhile` may be called in it."""

    def bring(self) -> bool:
        """Bring the segments here that others have made since; return whether there were any."""


def make_segments(
    segments: Segments,
    run: Path,
    progress: ProgressCallback,
    publish: Callable[[], None],
    exchange: Exchange | None = None,
) -> None:
    """Make all segments of a run but those that others make, wait for these, and finish the run.

    The first one is made before others are claimed.
    """
    count, each = segments.segment_count(run), 1  # units of progress of a segment

    def report(step: Progress) -> None:
        nonlocal each
        each = max(step.total, 1)
        tell(step.done)

    def tell(done: int = 0) -> None:
        made = sum(segments.made(run, number) for number in range(count))
        figures = {SEGMENTS: float(count), MADE: float(made)}
        progress(Progress("train", min(made * each + done, count * each), count * each, figures))

    def show() -> None:
        with _alone(run):
            if segments.assemble(run):
                publish()

    def bring() -> None:
        if exchange is not None and exchange.bring():
            show()

    bring()
    while not all(segments.made(run, number) for number in range(count)):
        if _make_one(segments, run, count, report, exchange, bring):
            show()
        else:
            time.sleep(LOOK)
        bring()
        tell()
    with _alone(run):  # a helper may be about to publish the last segment
        segments.finish(run, lambda step: None)


def help_with_segment(
    segments: Segments,
    run: Path,
    progress: ProgressCallback,
    publish: Callable[[], None],
    exchange: Exchange | None = None,
) -> None:
    """Make one segment of a run after its first one; none if all are made or claimed.

    With an `exchange` whoever has the job publishes it.
    """
    if not segments.made(run, 0):
        return
    if _make_one(segments, run, segments.segment_count(run), progress, exchange) and exchange is None:
        with _alone(run):
            if not _is_complete(run) and segments.assemble(run):
                publish()


def _is_complete(run: Path) -> bool:
    """Return whether the job's own worker has finished the scene meanwhile."""
    try:
        return "live" not in json.loads((run / "scene" / "manifest.json").read_bytes())
    except FileNotFoundError:
        return False


def _make_one(
    segments: Segments,
    run: Path,
    count: int,
    progress: ProgressCallback,
    exchange: Exchange | None,
    meanwhile: Callable[[], object] = lambda: None,
) -> bool:
    """Make the first segment that nobody else makes; return whether there was one."""
    free = range(count) if segments.made(run, 0) else range(1)
    for number in free:
        if segments.made(run, number):
            continue
        claim = _claimed(run, number) if exchange is None or number == 0 else exchange.claimed(number, meanwhile)
        with claim as claimed:
            if not claimed or segments.made(run, number):
                continue
            segments.make_segment(run, number, progress)
        return True
    return False


@contextlib.contextmanager
def _claimed(run: Path, number: int) -> Iterator[bool]:
    with _opened(run, f"{number}.lock") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            yield False
        else:
            yield True


@contextlib.contextmanager
def _alone(run: Path) -> Iterator[None]:
    with _opened(run, "scene.lock") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


@contextlib.contextmanager
def _opened(run: Path, name: str) -> Iterator[int]:
    folder = run / "segments"
    folder.mkdir(exist_ok=True)
    with (folder / name).open("w") as file:
        yield file.fileno()
