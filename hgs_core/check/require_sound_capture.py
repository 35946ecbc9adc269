"""Stopping where training would be in vain."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from hgs_core.base.errors import InputError
from hgs_core.check.findings import CaptureCheck

__all__ = ["require_sound"]


def require_sound(check: CaptureCheck, capture: Path, held_out: Collection[str] = ()) -> None:
    """Refuse a capture that cannot come out right; dead cameras that are `held_out` do not matter.

    Raises:
        InputError: names the first fault, its cure, and how many more there are.
    """
    stops = [one for one in check.stops if not (one.of_pictures and set(held_out).issuperset(one.cameras))]
    if stops:
        first, more = stops[0], len(stops) - 1
        where = f"{capture}, camera {', '.join(first.cameras)}" if first.cameras else str(capture)
        others = f" (and {more} more, see hgs check)" if more else ""
        way_on = (
            "" if first.of_pictures else "; or train with --trust-poses"
        )  # dead pictures have nothing to do with poses
        raise InputError(where, first.problem + others, first.cure + way_on)
