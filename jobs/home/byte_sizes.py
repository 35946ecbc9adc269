"""Numbers of bytes as people write them: 500G."""

from __future__ import annotations

import re

from hgs_core.base.errors import InputError

__all__ = ["bytes_of"]

_UNITS = {"": 1, "K": 1000, "M": 1000**2, "G": 1000**3, "T": 1000**4}


def bytes_of(text: str, where: str) -> float:
    """Return a number such as 20, 1.5 or 500G.

    Raises:
        InputError: it is none; names `where`.
    """
    match = re.fullmatch(r"([0-9]{1,15}(?:\.[0-9]+)?)([KMGT]?)B?", text.strip().upper())
    if match is None:
        raise InputError(where, f"{text!a} is no number", "give one such as 20, or of bytes 500G")
    return float(match[1]) * _UNITS[match[2]]
