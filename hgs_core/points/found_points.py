"""First points that were found in one go, on disk with all that the search goes on from."""

from __future__ import annotations

import dataclasses
import json
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hgs_core.base.atomic import replacing
from hgs_core.base.errors import InputError
from hgs_core.points.initial_points import Ranges
from hgs_core.points.point_cloud import CURE, PointCloud

__all__ = ["FoundPoints"]


@dataclass(frozen=True)
class FoundPoints:
    """The static points, or the moving points of a segment's moments, the latest last."""

    points: PointCloud
    at_end: int  # last points, those of the segment's last moment, at which the next one begins
    ranges: Ranges
    generator: np.random.Generator  # the state after the last random draw

    def save(self, path: Path) -> None:
        """Write an .npz file that `PointCloud.load` reads, too; it appears complete or not at all."""
        search = {"at_end": self.at_end, "ranges": self.ranges, "generator": self.generator.bit_generator.state}
        with replacing(path) as file:
            np.savez(file, search=np.array(json.dumps(search)), **dataclasses.asdict(self.points))

    @classmethod
    def load(cls, path: Path) -> FoundPoints:
        """Read a file that `save` wrote.

        Raises:
            InputError: the file is missing or damaged.
        """
        points = PointCloud.load(path)
        try:
            with np.load(path, allow_pickle=False) as file:
                search: dict[str, Any] = json.loads(str(file["search"]))
            generator = np.random.default_rng()
            generator.bit_generator.state = search["generator"]
            ranges = [(float(near), float(far)) for near, far in search["ranges"]]
            at_end = int(search["at_end"])
        except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
            raise InputError(path, f"unreadable as first points ({error})", CURE) from error
        return cls(points, at_end, ranges, generator)
