"""The memory that this process may still take: of the machine, and within the limits of its control groups."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from hgs_core.base.errors import InputError

__all__ = ["free_memory"]

_GROUPS = Path("sys/fs/cgroup")
_OLD, _NEW = ("memory.limit_in_bytes", "memory.usage_in_bytes"), ("memory.max", "memory.current")  # versions 1 and 2
_CACHES = ("total_inactive_file", "inactive_file")  # bytes that a group gives back when it is short of memory


def free_memory(root: Path = Path("/")) -> int | None:
    """Return how many bytes the process may take before the system ends it or another; None where it does not tell.

    HGS_MEMORY_MIB, if it is set. Else the system's MemAvailable, or less where the limit of a control group that holds
    the process (version 1 or 2) leaves less. `root` is where /proc and /sys lie.

    Raises:
        InputError: HGS_MEMORY_MIB is not a positive integer.
    """
    text = os.environ.get("HGS_MEMORY_MIB", "")
    if text:
        if not (text.isascii() and text.isdecimal() and int(text) > 0):
            raise InputError("HGS_MEMORY_MIB", f"{text[:40]!a} is not a positive integer")
        return int(text) << 20
    machine = _kilobytes(root / "proc/meminfo", "MemAvailable")
    return min((max(0, room) for room in (machine, *_of_groups(root)) if room is not None), default=None)


def _of_groups(root: Path) -> Iterator[int]:
    """Yield the room in each group from the process's own up to the first; a container may see its own alone."""
    for controllers, group in _groups(root):
        base = root / _GROUPS / ("memory" if controllers == "memory" else "")
        names = _OLD if controllers == "memory" else _NEW
        for path in (PurePosixPath(group), *PurePosixPath(group).parents):
            folder = base / str(path).lstrip("/")
            limit, taken = (_number(folder / name) for name in names)
            if limit is not None and taken is not None:
                yield limit - taken + _given_back(folder / "memory.stat")


def _groups(root: Path) -> Iterator[tuple[str, str]]:
    """Yield ("memory", path) of version 1 and ("", path) of version 2."""
    for line in _lines(root / "proc/self/cgroup"):
        _, controllers, path = line.split(":", 2)
        if controllers in ("", "memory"):
            yield controllers, os.path.normpath(path)


def _given_back(statistics: Path) -> int:
    values = dict(line.split(" ", 1) for line in _lines(statistics) if " " in line)
    return next((int(values[name]) for name in _CACHES if name in values), 0)


def _kilobytes(file: Path, name: str) -> int | None:
    found = next((line.split()[1] for line in _lines(file) if line.startswith(f"{name}:")), None)
    return None if found is None else int(found) << 10


def _number(file: Path) -> int | None:
    text = "".join(_lines(file)).strip()
    return int(text) if text.isdecimal() else None  # version 2 writes "max" where there is no limit


def _lines(file: Path) -> list[str]:
    try:
        return file.read_text().splitlines()
    except OSError:
        return []
