"""How closely a scene is encoded, and how it is cut into chunks."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

from hgs_core.base.errors import InputError

__all__ = ["EncodeSettings"]


@dataclass(frozen=True)
class EncodeSettings:
    """Quantiser steps and sizes.

    Steps are those of a splat whose utility (`utility.py`) is 1; a splat that shows less has wider ones, in
    proportion to 1 / sqrt(utility) and at most `largest_*`, and one that shows more narrower ones. All grow with
    `coarseness`.
    """

    coarseness: float = 1.0
    dynamic_share: float = 1.0  # coarseness of dynamic splats over that of static ones
    position_step: float = 0.085  # effective radii of the splat
    shape_step: float = 0.045  # ln of the standard deviation on the screen, i.e. 4.5 %
    rotation_step: float = 1.0  # quaternion components, shape steps over the splat's elongation
    opacity_step: float = 0.05  # share of the opacity
    rgb_step: float = 0.024
    largest_position_step: float = 0.5  # pixels of the cameras that see the splat
    largest_shape_step: float = 0.35
    largest_rotation_step: float = 0.075
    largest_opacity_step: float = 0.03  # units of the stored number
    largest_rgb_step: float = 0.1
    prune: float = 0.0001  # static splats that would be missed less than this times coarseness squared are dropped
    prune_dynamic: float = 0.0006  # and dynamic ones, which take more bytes
    shortest_life: float = 0.05  # frames; half the life of the briefest splat
    slice_seconds: float = 0.5
    static_chunk_splats: int = 4096  # most splats
    dynamic_chunk_splats: int = 8192  # most splats
    small_chunk_splats: int = 1024  # chunks of fewer splats are joined with the next
    compression_level: int = 19  # zstd level

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
            elif not (math.isfinite(value) and (1e-9 <= value <= 1e9 or (value == 0 and "prune" in field.name))):
                raise InputError(f"encode.{field.name}", f"{value!r} is out of range", "give a number from 1e-9 to 1e9")
        if self.compression_level > 22:
            raise InputError("encode.compression_level", f"{self.compression_level} is too large", "give 1 to 22")

    @property
    def of_dynamic(self) -> EncodeSettings:
        """The settings in which `coarseness` is that of dynamic splats."""
        return dataclasses.replace(self, coarseness=self.coarseness * self.dynamic_share, dynamic_share=1.0)
