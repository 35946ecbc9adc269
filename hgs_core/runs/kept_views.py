"""views.json: the cameras and the clock that an edited scene took over from the one it was made of."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles
from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.fit.encoding_views import EncodeViews, views_around
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import HybridScene

__all__ = ["KeptViews"]


@dataclass(frozen=True)
class KeptViews:
    """The views of a scene without a capture, for encoding and further edits."""

    title: str
    cameras: tuple[Camera, ...]  # none: they were made up, and are made up again for what is left
    held_out: frozenset[str]  # names of cameras that encoding does not look from
    times: Doubles  # [F] seconds of the frames
    up: tuple[float, float, float] | None  # unit vector; None: what the cameras tell

    def of(self, scene: HybridScene[NDArray[np.float32]]) -> EncodeViews:
        """Return the views to encode a scene for."""
        if not self.cameras:
            return views_around(scene, self.title)
        trained = {i: camera for i, camera in enumerate(self.cameras) if camera.name not in self.held_out}
        return EncodeViews(
            self.title,
            self.cameras,
            trained,
            self.times,
            None,
            photographed=True,
            up=self.up,
        )

    def save(self, path: Path) -> None:
        """Write the file atomically."""
        value: dict[str, Any] = {
            "title": self.title,
            "cameras": [camera.to_json() for camera in self.cameras],
            "held_out": sorted(self.held_out),
            "times": [float(time) for time in self.times],
            "up": None if self.up is None else list(self.up),
        }
        write_bytes(path, json.dumps(value, indent=1).encode())

    @classmethod
    def load(cls, path: Path) -> KeptViews:
        """Read a file that `save` wrote.

        Raises:
            InputError: the file is missing or damaged.
        """
        try:
            value = json.loads(path.read_text())
            cameras = tuple(Camera.from_json(camera) for camera in value["cameras"])
            times = np.array(value["times"], np.float64)
            up = None if value["up"] is None else tuple(map(float, value["up"]))
            if up is not None and len(up) != 3:
                raise ValueError(f"up has {len(up)} numbers")
            return cls(str(value["title"]), cameras, frozenset(map(str, value["held_out"])), times, up)
        except (OSError, KeyError, TypeError, ValueError) as error:
            raise InputError(path, f"unreadable ({error!r})", "edit the first run again") from error
