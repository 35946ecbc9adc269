"""The option --fps of the commands that draw or sample a scene."""

from __future__ import annotations

import re
from fractions import Fraction

from hgs_core.base.errors import InputError

__all__ = ["frame_rate"]

_MOST = 1000
_RATE = re.compile(r"\d{1,6}(\.\d{1,6}|/\d{1,6})?")


def frame_rate(text: str) -> Fraction:
    """Return a rate of frames, like 25, 29.97 or 30000/1001.

    Raises:
        InputError: the text is no rate, or too high a one.
    """
    try:
        rate = Fraction(text).limit_denominator(1001) if _RATE.fullmatch(text) else None
    except ZeroDivisionError:
        rate = None
    if rate is None or not 0 < rate <= _MOST:
        raise InputError("--fps", f"{text!r} is no rate", f"give a number above 0, at most {_MOST}")
    return rate
