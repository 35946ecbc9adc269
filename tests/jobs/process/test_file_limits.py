"""Limits on files, in a process of its own: they cannot be lifted."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from jobs.process.file_limits import met_file_limit

PROGRAM = """
import contextlib, resource, subprocess, sys
from pathlib import Path
from jobs.process.file_limits import limit_files, met_file_limit
limit_files(64, 5000)
"""


def said_by(program: str, folder: Path) -> str:
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM + program], cwd=folder, capture_output=True, text=True, check=True
    )
    return done.stdout.strip()


def opening(body: str) -> str:
    return (
        f"opened = []\ntry:\n    while True: opened.append(Path('/dev/null').open())\nexcept OSError as error:\n{body}"
    )


def test_too_many_open_files(tmp_path: Path) -> None:
    line = "too many open files: limit 64; raise HGS_STAGE_FILES (or ulimit -n) if they are meant"
    assert said_by(opening("    print(met_file_limit(error))"), tmp_path) == line
    hidden = opening("    print(met_file_limit(ValueError('the picture cannot be read')))")
    assert said_by(hidden, tmp_path) == line


def test_a_file_that_gets_too_large(tmp_path: Path) -> None:
    program = """
try:
    with Path('log').open('wb', buffering=0) as file:
        for _ in range(2):
            file.write(bytes(5000))
except OSError as error:
    print(met_file_limit(error))
"""
    line = "a file too large: limit 5000 bytes; raise HGS_STAGE_FILE_SIZE (or ulimit -f) if it is meant"
    assert said_by(program, tmp_path) == line
    assert (tmp_path / "log").stat().st_size == 5000


def test_processes_that_it_starts_have_the_same_limits(tmp_path: Path) -> None:
    assert said_by("print(subprocess.check_output(['sh', '-c', 'ulimit -Hn'], text=True))", tmp_path) == "64"


def test_there_are_no_core_dumps(tmp_path: Path) -> None:
    crash = "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)"
    program = (
        f"print(subprocess.run([sys.executable, '-c', {crash!r}]).returncode, resource.getrlimit(resource.RLIMIT_CORE))"
    )
    assert said_by(program, tmp_path) == "-11 (1, 1)"
    assert list(tmp_path.iterdir()) == []


def test_lower_limits_of_the_system_stay(tmp_path: Path) -> None:
    program = "limit_files(1000, 1e9); print(resource.getrlimit(resource.RLIMIT_NOFILE))"
    assert said_by(program, tmp_path) == "(64, 64)"


@pytest.mark.parametrize("code", [errno.ENOENT, errno.ENOSPC, errno.ENFILE])
def test_other_errors_are_not(code: int) -> None:
    assert met_file_limit(OSError(code, os.strerror(code), "/data/x")) == ""


def test_what_libraries_say_counts() -> None:
    wrapped = RuntimeError("failed to open /data/x: Too many open files (os error 24)")
    assert met_file_limit(wrapped).startswith("too many open files: limit ")
