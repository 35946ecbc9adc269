"""Numbers and near words in sentences for people."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

__all__ = ["counted", "did_you_mean"]

_NEAR = 0.6  # of difflib's ratio, 0 to 1: a letter or two apart


def counted(count: int, noun: str, plural: str = "") -> str:
    """Return a number with its noun: "1 camera", "2 cameras"; `plural` where it is not the noun with an s."""
    return f"{count:,} {noun if count == 1 else plural or noun + 's'}"


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return "did you mean ...?" with the known word that is nearest, or "" if none is near."""
    near = difflib.get_close_matches(word[:100], list(known), 1, _NEAR)
    return f"did you mean {near[0]}?" if near else ""
