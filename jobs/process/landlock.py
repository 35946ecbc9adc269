"""Landlock: the only files that the kernel lets this process use, and no TCP port; Linux, without any privilege.

libc has no functions for its three system calls. The kernel's numbers are those of linux/landlock.h.
"""

from __future__ import annotations

import ctypes
import os
import struct
import sys
from collections.abc import Mapping
from contextlib import closing
from enum import IntFlag
from pathlib import Path

__all__ = ["Right", "landlock_version", "restrict_files"]

_CREATE_RULESET, _ADD_RULE, _RESTRICT_SELF = 444, 445, 446  # system calls, equal on all of Python's architectures
_ASK_VERSION = 1
_TASKS = Path("/proc/self/task")  # the threads of this process
_PATH_BENEATH = 1
_SET_NO_NEW_PRIVS = 38  # prctl(2)
_BIND_AND_CONNECT = 3
_TCP_SINCE = 4  # version
_SOCKETS_AND_SIGNALS = 3  # abstract Unix sockets and signals beyond the sandbox
_OUTSIDE_SINCE = 6  # version


class Right(IntFlag):
    """Rights to files and folders, as the kernel numbers them."""

    EXECUTE = 1 << 0
    WRITE_FILE = 1 << 1
    READ_FILE = 1 << 2
    READ_DIR = 1 << 3
    REMOVE_DIR = 1 << 4
    REMOVE_FILE = 1 << 5
    MAKE_CHAR = 1 << 6
    MAKE_DIR = 1 << 7
    MAKE_REG = 1 << 8
    MAKE_SOCK = 1 << 9
    MAKE_FIFO = 1 << 10
    MAKE_BLOCK = 1 << 11
    MAKE_SYM = 1 << 12
    REFER = 1 << 13
    TRUNCATE = 1 << 14
    IOCTL_DEV = 1 << 15

    READ = READ_FILE | READ_DIR
    RUN = READ | EXECUTE
    WRITE = READ | WRITE_FILE | REMOVE_DIR | REMOVE_FILE | MAKE_DIR | MAKE_REG | REFER | TRUNCATE


_SINCE = {Right.REFER: 2, Right.TRUNCATE: 3, Right.IOCTL_DEV: 5}  # versions; all others: 1
_OF_FILES = Right.EXECUTE | Right.WRITE_FILE | Right.READ_FILE | Right.TRUNCATE | Right.IOCTL_DEV


def landlock_version() -> int:
    """Return the kernel's version of Landlock; 0 where it has none, or has it switched off."""
    if sys.platform != "linux":
        return 0
    ask, nothing = ctypes.c_long(_CREATE_RULESET), ctypes.c_size_t(0)
    version: int = _libc().syscall(ask, None, nothing, ctypes.c_uint(_ASK_VERSION))
    return max(0, version)


def restrict_files(rights: Mapping[Path, Right]) -> None:
    """Refuse this process, and those that it starts, all files but these and those below, and all TCP ports.

    What is open stays open. Paths that do not exist are passed over. Signals to processes outside, their memory and
    their environment are refused too. Where the kernel lacks Landlock nothing is refused, and where its version is old
    less.

    Raises:
        RuntimeError: there are other threads, which would stay free and share this one's memory.
        OSError: the kernel does not take the rules.
    """
    version = landlock_version()
    if version == 0:
        return
    if _TASKS.is_dir() and len(list(_TASKS.iterdir())) > 1:
        raise RuntimeError("only a process of one thread can be restricted")
    known = _known(version)
    attributes = _ruleset(version)
    ruleset = _call(_CREATE_RULESET, attributes, ctypes.c_size_t(len(attributes)), ctypes.c_uint(0))
    with closing(os.fdopen(ruleset, "rb", buffering=0)):
        for path, allowed in rights.items():
            _add(ruleset, path, allowed & known)
        if _libc().prctl(_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0:
            raise _fault("no new privileges")
        _call(_RESTRICT_SELF, ctypes.c_int(ruleset), ctypes.c_uint(0))


def _known(version: int) -> Right:
    return Right(sum(right for right in Right if _SINCE.get(right, 1) <= version))


def _ruleset(version: int) -> bytes:
    """Return the kernel's struct landlock_ruleset_attr; an older kernel accepts zeros in fields of later versions."""
    tcp, outside = _BIND_AND_CONNECT * (version >= _TCP_SINCE), _SOCKETS_AND_SIGNALS * (version >= _OUTSIDE_SINCE)
    return struct.pack("=QQQ", _known(version), tcp, outside)


def _add(ruleset: int, path: Path, allowed: Right) -> None:
    try:
        place = os.open(path, os.O_PATH | os.O_CLOEXEC)
    except (FileNotFoundError, NotADirectoryError, PermissionError):
        return
    try:
        rule = struct.pack("=Qi", allowed if path.is_dir() else allowed & _OF_FILES, place)
        _call(_ADD_RULE, ctypes.c_int(ruleset), ctypes.c_int(_PATH_BENEATH), rule, ctypes.c_uint(0))
    finally:
        os.close(place)


def _call(number: int, *arguments: object) -> int:
    result: int = _libc().syscall(ctypes.c_long(number), *arguments)
    if result < 0:
        raise _fault(f"Landlock, system call {number}")
    return result


def _fault(what: str) -> OSError:
    code = ctypes.get_errno()
    return OSError(code, f"{what}: {os.strerror(code)}")


def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None, use_errno=True)
