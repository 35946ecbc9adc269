"""How closely a scene is encoded, and how it is cut into chunks."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

from hgs_core.errors import InputError

__all__ = ["EncodeSettings"]


@dataclass(frozen=True)
class EncodeSettings:
    """Error bounds and sizes. Every bound holds for every splat; `encode_scene` checks it by decoding.

    A bound is relaxed only where nothing can show it: positions of splats far behind the scene (in proportion to
    their distance), and numbers so large that float32 cannot hold them more finely.
    """

    position_error: float | None = None  # world units, per axis, at every moment of a splat's life; None: `pixel_error`
    pixel_error: float = 0.07  # pixels of the capture at the cameras' median distance from the scene's centre
    log_scale_error: float = 0.04  # i.e. 4 % of a splat's size
    rotation_error: float = 0.005  # distance of unit quaternions; twice that is an angle in radians
    opacity_error: float = 1 / 510  # of the peak
    fade_error: float = 0.01  # of the opacity at any moment, because of the time attributes
    rgb_error: float = 1 / 510
    smallest_scale: float = 0.1  # in position errors: a splat thinner than this is drawn as this thin
    shortest_life: float = 0.05  # in frames: half the life of the briefest splat
    slice_seconds: float = 0.5
    static_chunk_splats: int = 8192  # at most
    dynamic_chunk_splats: int = 8192  # at most
    small_chunk_splats: int = 1024  # dynamic chunks of fewer splats are joined with those that live longer
    compression_level: int = 19  # of zstd

    def __post_init__(self) -> None:
        """Check every range.

        Raises:
            InputError: names the field and the range it must lie in.
        """
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if field.type == "int":
                if isinstance(value, bool) or not isinstance(value, int) or value < 1:
                    raise InputError(f"encode.{field.name}", f"{value!r} is not a whole number of at least 1")
            elif value is not None and not (math.isfinite(value) and 1e-9 <= value <= 1e9):
                raise InputError(f"encode.{field.name}", f"{value!r} is out of range", "give a number from 1e-9 to 1e9")
        if self.compression_level > 22:
            raise InputError("encode.compression_level", f"{self.compression_level} is too large", "give 1 to 22")
