"""Processor time of a process's descendants, such as a browser's, undisturbed by other work."""

from __future__ import annotations

import os
from pathlib import Path

__all__ = ["descendants_cpu_seconds"]


def descendants_cpu_seconds(root: int | None = None, proc: Path = Path("/proc")) -> float:
    """Return the processor time, user and system, of all living descendants of a process, in seconds.

    Args:
        root: process id; this process if None. Its own time is not counted.
        proc: where the kernel tells of its processes.

    Raises:
        OSError: the system has no /proc.
    """
    ticks = os.sysconf("SC_CLK_TCK")
    children: dict[int, list[int]] = {}
    seconds: dict[int, float] = {}
    for entry in proc.iterdir():
        if not entry.name.isdigit():
            continue
        try:
            # After the name, which is in parentheses and may hold anything: proc(5), /proc/pid/stat.
            fields = (entry / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue  # it has ended meanwhile
        process, parent = int(entry.name), int(fields[1])
        children.setdefault(parent, []).append(process)
        seconds[process] = (int(fields[11]) + int(fields[12])) / ticks
    total, todo = 0.0, [os.getpid() if root is None else root]
    while todo:
        for child in children.get(todo.pop(), []):
            total += seconds[child]
            todo.append(child)
    return total
