"""Numbers and values in sentences for people."""

from __future__ import annotations

from typing import Any

__all__ = ["counted", "shown"]

_SHOWN = 40  # characters of a bad value that an error repeats


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
