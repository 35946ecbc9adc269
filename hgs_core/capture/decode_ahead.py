"""Pictures decoded ahead of their use, on all cores."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence

from hgs_core.base.cores import core_pool, watched
from hgs_core.base.progress import Progress, ProgressCallback

__all__ = ["decode_ahead"]

_STAGE = "frames"


def decode_ahead(
    frames: Mapping[int, Sequence[int]], decode: Callable[[int, int], object], progress: ProgressCallback
) -> None:
    """Call `decode(camera, frame)` for the frames of every camera: cameras side by side, their frames in order.

    Raises:
        InputError: as `decode`.
        StageStopped: the callback wishes so.
    """
    total, done, unwanted = sum(len(own) for own in frames.values()), dict.fromkeys(frames, 0), threading.Event()

    def decode_camera(camera: int) -> None:
        for frame in frames[camera]:
            if unwanted.is_set():
                return
            decode(camera, frame)
            done[camera] += 1

    def report() -> None:
        progress(Progress(_STAGE, sum(done.values()), total))

    report()
    with core_pool() as pool:
        watched({camera: pool.submit(decode_camera, camera) for camera in frames}, report, unwanted)
