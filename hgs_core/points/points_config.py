"""How many points a run starts from, and from which moments."""

from __future__ import annotations

from dataclasses import dataclass

from hgs_core.base.config_fields import Range, check_fields

__all__ = ["PointsConfig"]

_RANGES: dict[str, Range] = {
    "static": (0, 1_000_000),  # a point for every second pixel of a Full HD picture
    "dynamic": (0, 1_000_000),
    "interval": (0.001, 1e6),  # a camera of 1000 frames a second; longer than any capture: one moment
}


@dataclass(frozen=True)
class PointsConfig:
    """The first points that are asked for."""

    static: int = 30_000
    dynamic: int = 8_000  # moving points for every second of the capture
    interval: float = 1 / 3  # seconds between the moments that dynamic points are taken from (interleaved frames)
    stereo: bool = True  # static points by multi-view stereo; else a coarse sweep, at most 6,000
    continued: bool = True  # stereo's surfaces go on where one camera looks alone; else nothing starts there
    hull: bool = True  # cameras far apart start from silhouettes (docs/training.md); else as all others do
    discs: bool = False  # splats of points on surfaces start as discs that lie in these; else all start round

    def __post_init__(self) -> None:
        """Check every field.

        Raises:
            InputError: names the field, the value and the range.
        """
        check_fields(self, "config.points", _RANGES)

    def dynamic_in(self, seconds: float) -> int:
        """Return the number of moving points at the start of a capture of so many seconds; of one second at least."""
        return round(self.dynamic * max(1.0, seconds))
