"""Numbers, values and near words in sentences for people."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any

__all__ = ["counted", "did_you_mean", "shown"]

_SHOWN = 40  # characters of a bad value that an error repeats
_NEAR = 0.6  # least ratio of difflib, 0 to 1: a letter or two apart


def counted(count: int, noun: str, plural: str = "") -> str:
    """Return a number with its noun: "1 camera", "2 cameras"; `plural` where it is not the noun with an s."""
    return f"{count:,} {noun if count == 1 else plural or noun + 's'}"


def shown(value: Any) -> str:
    """Return a bad value as an error repeats it: its first 40 characters."""
    try:
        text = repr(value)
    except ValueError:  # Python writes out no int of thousands of digits
        text = "a number of thousands of digits"
    except RecursionError:
        text = "lists in lists"
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return "did you mean ...?" with the known word that is nearest, or "" if none is near."""
    near = difflib.get_close_matches(word[:100], list(known), 1, _NEAR)
    return f"did you mean {near[0]}?" if near else ""
