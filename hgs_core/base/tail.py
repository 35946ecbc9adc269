"""The end of a text file, without reading the rest."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

__all__ = ["Tail", "last_lines"]


@dataclass(frozen=True)
class Tail:
    """The last lines of a file, without their ends; `whole` if there are no others."""

    lines: tuple[str, ...] = ()
    whole: bool = True


def last_lines(path: Path, count: int, most_bytes: int) -> Tail:
    """Return at most `count` lines from the last `most_bytes` bytes of a file; none where there is no file.

    A line of which the beginning lies further back is left out, unless it is the only one. Bytes that are not UTF-8
    become U+FFFD.

    Raises:
        OSError: the file is there and cannot be read.
    """
    try:
        file = path.open("rb")
    except FileNotFoundError:
        return Tail()
    with file:
        start = max(0, file.seek(0, os.SEEK_END) - most_bytes)
        file.seek(start)
        text = file.read(most_bytes).decode("utf-8", "replace")
    lines = text.removesuffix("\n").split("\n") if text else []
    if start and len(lines) > 1:
        lines = lines[1:]
    return Tail(tuple(lines[-count:] if count else ()), whole=not start and len(lines) <= count)
