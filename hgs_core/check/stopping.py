"""Stopping where training would be in vain."""

from __future__ import annotations

from pathlib import Path

from hgs_core.base.errors import InputError
from hgs_core.check.findings import CaptureCheck

__all__ = ["require_sound"]


def require_sound(check: CaptureCheck, capture: Path) -> None:
    """Refuse a capture that cannot come out right.

    Raises:
        InputError: names the first fault, its cure, and how many more there are.
    """
    if check.stops:
        first, more = check.stops[0], len(check.stops) - 1
        where = f"{capture}, camera {', '.join(first.cameras)}" if first.cameras else str(capture)
        others = f" (and {more} more, see hgs check)" if more else ""
        raise InputError(where, first.problem + others, f"{first.cure}; or train with --trust-poses")
