"""The sandbox of processes that open strangers' files: the kernel refuses them all other files, and TCP."""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from jobs.process.landlock import Right, landlock_version, restrict_files

__all__ = ["enter_sandbox", "missing_from_sandbox", "with_links"]

_PACKAGES = ("hgs_core", "jobs", "server")
# Of /proc no other process: where this one is root, their environments could be read.
_SYSTEM = (
    *("/usr", "/lib", "/lib32", "/lib64", "/bin", "/sbin", "/nix/store", "/sys", "/dev/urandom", "/dev/random"),
    *("/etc/ld.so.cache", "/etc/localtime", "/etc/nsswitch.conf", "/etc/passwd", "/etc/group"),
    *("/proc/self", "/proc/sys", "/proc/cpuinfo", "/proc/filesystems", "/proc/meminfo", "/proc/stat", "/proc/vmstat"),
)
_DEVICES = ("/dev/null", "/dev/zero", "/dev/full")
_MOST_ENTRIES = 500_000  # files and folders of one capture
_DEEPEST = 6  # levels below a capture
_WHOLE = 6  # version of Landlock that refuses all that `enter_sandbox` promises


def enter_sandbox(readable: Iterable[Path], writable: Iterable[Path] = ()) -> None:
    """Refuse this process, and those that it starts, all files but these, Python's and the system's; and TCP.

    Raises:
        RuntimeError: there are other threads already.
        OSError: the kernel does not take the rules.
    """
    rights = dict.fromkeys(_installation(), Right.RUN)
    rights.update(dict.fromkeys(readable, Right.READ))
    rights.update(dict.fromkeys(map(Path, _DEVICES), Right.READ | Right.WRITE_FILE))
    rights.update(dict.fromkeys(writable, Right.WRITE))
    restrict_files(rights)


def with_links(capture: Path) -> Iterator[Path]:
    """Yield a capture and the targets of links in it: uploads have none, and the server has looked at others."""
    yield capture
    waiting, looked_at = [(capture, 0)], 0
    while waiting and looked_at < _MOST_ENTRIES:
        folder, depth = waiting.pop()
        try:
            with os.scandir(folder) as entries:
                for entry in entries:
                    looked_at += 1
                    if entry.is_symlink():
                        yield Path(os.path.realpath(entry.path))
                    if depth < _DEEPEST and entry.is_dir():
                        waiting.append((Path(entry.path), depth + 1))
        except OSError:  # a file, or a folder that cannot be read
            continue


def missing_from_sandbox() -> str:
    """Return in one line this kernel's gaps in the sandbox of processes that open captures; "" if there are none."""
    version = landlock_version()
    if version >= _WHOLE:
        return ""
    if version == 0:
        return (
            "no sandbox: this kernel has no Landlock (Linux 5.13 or newer, with landlock in lsm=), so a flaw in a "
            "video decoder would have all files of this user"
        )
    refused = "TCP connections and signals" if version < 4 else "signals to other processes"
    return f"sandbox without limits to {refused}: Landlock {version} of this kernel; Linux 6.12 has them"


def _installation() -> Iterator[Path]:
    yield from map(Path, _SYSTEM)
    yield from map(Path, {sys.prefix, sys.exec_prefix, sys.base_prefix, sys.base_exec_prefix})
    yield from (Path(part) for part in (*sys.path, *os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep)) if part)
    for name in _PACKAGES:
        if (spec := importlib.util.find_spec(name)) is not None:
            yield from map(Path, spec.submodule_search_locations or ())
