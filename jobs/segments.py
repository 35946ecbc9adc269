"""The segments of a run, made by several workers at once: the one that has the job, and others that help.

A segment is claimed by a file lock, which the kernel frees when its process dies: whoever comes next goes on from its
checkpoint. After every segment the scene, as far as it has no gap, is published again.
"""

from __future__ import annotations

import contextlib
import fcntl
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Protocol

from hgs_core.base.progress import Progress, ProgressCallback

__all__ = ["MADE", "SEGMENTS", "Segments", "help_with_segment", "make_segments"]

SEGMENTS, MADE = "segments", "made"  # figures of a training: how many segments there are, and how many are made
LOOK = 0.5  # seconds between two looks whether others have made theirs


class Segments(Protocol):
    """What a pipeline does for one segment; `hgs_core.runs.by_segment`."""

    def segment_count(self, run: Path) -> int: ...  # noqa: D102
    def made(self, run: Path, number: int) -> bool: ...  # noqa: D102
    def make_segment(self, run: Path, number: int, progress: ProgressCallback) -> None: ...  # noqa: D102
    def assemble(self, run: Path) -> int: ...  # noqa: D102
    def finish(self, run: Path, progress: ProgressCallback) -> None: ...  # noqa: D102


def make_segments(segments: Segments, run: Path, progress: ProgressCallback, publish: Callable[[], None]) -> None:
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

    while not all(segments.made(run, number) for number in range(count)):
        if not _make_one(segments, run, count, report, publish):
            time.sleep(LOOK)
        tell()
    segments.finish(run, lambda step: None)


def help_with_segment(segments: Segments, run: Path, progress: ProgressCallback, publish: Callable[[], None]) -> None:
    """Make one segment of a run whose first one is made; none if all are made or claimed."""
    if segments.made(run, 0):
        _make_one(segments, run, segments.segment_count(run), progress, publish)


def _make_one(
    segments: Segments, run: Path, count: int, progress: ProgressCallback, publish: Callable[[], None]
) -> bool:
    """Make the first segment that nobody else makes; return whether there was one."""
    free = range(count) if segments.made(run, 0) else range(1)
    for number in free:
        if segments.made(run, number):
            continue
        with _claimed(run, number) as claimed:
            if not claimed or segments.made(run, number):
                continue
            segments.make_segment(run, number, progress)
        with _alone(run):
            if segments.assemble(run):
                publish()
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
