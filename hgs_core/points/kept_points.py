"""The first points of a capture on disk: a file for each segment, and two that all segments share.

| file      | content                                                                |
|-----------|------------------------------------------------------------------------|
| still.npz | static points                                                          |
| N.npz     | moving points at the moments of segment N                              |
| backdrop.json | surface of the still points, where cameras stand far apart; backdrop.npz: given depths |
| near.json | near planes of all cameras, the last file: with it all are there |
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.points.backdrop import save_backdrop
from hgs_core.points.found_points import FoundPoints
from hgs_core.points.initial_points import PointSearch
from hgs_core.points.near_plane import save_near_planes, with_near_planes
from hgs_core.points.point_cloud import PointCloud

__all__ = ["BACKDROP", "keep_points", "segment_points"]

_STAGE = "points"
_STILL = "still.npz"
BACKDROP = "backdrop.json"
"""Name of the file of the backdrop."""
_NEAR_PLANES = "near.json"


def keep_points(
    folder: Path,
    search: PointSearch,
    segments: Sequence[Sequence[int]],  # the moments of each: frames, ascending; one begins where the last one ended
    *,
    seed: int,
    progress: ProgressCallback,
) -> None:
    """Find first points, after those that the folder has; the bits are the same in any case.

    A segment's file is written as soon as its points are found.

    Raises:
        InputError: a picture is missing or unreadable, or a file of the folder is damaged.
        StageStopped: the callback wishes so.
    """
    moments = sorted({frame for segment in segments for frame in segment})
    files = [_file(folder, number) for number in range(len(segments))]
    still = folder / _STILL
    steps = len(moments) + 2
    features: PointCloud | None = None
    progress(Progress(_STAGE, 0, steps))
    if not still.exists():
        features = search.features(moments[0])
        ranges = search.ranges(features)
        progress(Progress(_STAGE, 1, steps))
        generator = np.random.default_rng(seed)
        if search.backdrop is not None:
            save_backdrop(folder / BACKDROP, search.backdrop)
        FoundPoints(search.still(features, ranges, generator), 0, ranges, generator).save(still)
    done, count = 2, 0  # count of the moving points that are found now
    progress(Progress(_STAGE, done, steps))
    for number, (own, file) in enumerate(zip(segments, files, strict=True)):
        new = own[1:] if number else own
        if file.exists():
            done += len(new)
            continue
        before = FoundPoints.load(files[number - 1] if number else still)
        generator = before.generator
        parts = [before.points.take(slice(len(before.points) - before.at_end, None))]
        if number == 0 and features is None:
            features = search.features(own[0])
        for frame in new:
            place = moments.index(frame)
            quota = search.dynamic_target * (place + 1) // len(moments) - search.dynamic_target * place // len(moments)
            known = features if place == 0 else None
            parts.append(search.moving(frame, quota, before.ranges, generator, known))
            done, count = done + 1, count + len(parts[-1])
            progress(Progress(_STAGE, done, steps, {"points": float(count)}))
        found = PointCloud.concatenate(parts)
        FoundPoints(found, len(parts[-1]), before.ranges, generator).save(file)
    cameras = search.capture.cameras
    save_near_planes(folder / _NEAR_PLANES, with_near_planes(cameras, _places(still, files)))


def segment_points(folder: Path, segment: int) -> PointCloud:
    """Return the static points and those of a segment's moments, the first and the last one included.

    Raises:
        InputError: a file is missing or damaged.
    """
    return PointCloud.concatenate([PointCloud.load(folder / _STILL), PointCloud.load(_file(folder, segment))])


def _file(folder: Path, segment: int) -> Path:
    return folder / f"{segment}.npz"


def _places(still: Path, files: Sequence[Path]) -> npt.NDArray[np.float32]:
    """Return all points [P, 3], each once."""
    parts = [PointCloud.load(still).xyz]
    for file in files:
        found = FoundPoints.load(file)
        parts.append(found.points.xyz[: len(found.points) - (found.at_end if file != files[-1] else 0)])
    return np.concatenate(parts)
