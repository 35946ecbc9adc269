from __future__ import annotations

import struct
import subprocess
import sys
from pathlib import Path

import pytest

from jobs.process import landlock
from jobs.process.landlock import Right, landlock_version, restrict_files

needs_landlock = pytest.mark.skipif(landlock_version() == 0, reason="the kernel has no Landlock")


@pytest.mark.parametrize(
    ("version", "rights", "tcp", "outside"),
    [(1, 13, 0, 0), (2, 14, 0, 0), (3, 15, 0, 0), (4, 15, 3, 0), (5, 16, 3, 0), (6, 16, 3, 3), (9, 16, 3, 3)],
)
def test_a_kernel_is_asked_for_what_its_version_knows(version: int, rights: int, tcp: int, outside: int) -> None:
    assert struct.unpack("=QQQ", landlock._ruleset(version)) == ((1 << rights) - 1, tcp, outside)


def test_nothing_is_restricted_where_the_kernel_cannot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(landlock, "landlock_version", lambda: 0)
    restrict_files({})
    (tmp_path / "file").write_text("written")


def test_a_kernel_without_the_system_call_has_version_0(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(landlock, "_CREATE_RULESET", 100_000)
    assert landlock_version() == 0


def restricted(rights: str, then: str) -> str:
    """Return the prints of a process that restricts itself first; `rights` and `then` are expressions of Python."""
    program = f"""
import os, sys, threading
from pathlib import Path
from jobs.process.landlock import Right, restrict_files
def tried(act):
    try:
        act()
    except OSError as error:
        return type(error).__name__
    return "done"
system = dict.fromkeys(map(Path, [*filter(None, sys.path), sys.prefix, sys.base_prefix, "/usr", "/lib"]), Right.RUN)
restrict_files(system | {rights})
print({then})
"""
    return subprocess.check_output([sys.executable, "-c", program], text=True).strip()


@needs_landlock
def test_a_folder_to_write_takes_files_and_folders_and_no_links(tmp_path: Path) -> None:
    acts = [
        "(here / 'a').write_text('a')",
        "(here / 'a').replace(here / 'b')",
        "(here / 'b').unlink()",
        "(here / 'c').mkdir()",
        "(here / 'c').rmdir()",
        "(here / 'd').symlink_to('/')",
        "os.mkfifo(here / 'e')",
    ]
    tries = ", ".join(f"tried(lambda: {act})" for act in acts)
    told = restricted(f"{{(here := Path({str(tmp_path)!r})): Right.WRITE}}", tries)
    assert told.split() == ["done"] * 5 + ["PermissionError"] * 2


@needs_landlock
def test_a_folder_to_read_cannot_be_written_and_its_programs_cannot_be_run(tmp_path: Path) -> None:
    program = tmp_path / "program"
    program.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    acts = "(here / 'program').read_text()", "(here / 'a').touch()", "os.execv(here / 'program', ['program'])"
    tries = ", ".join(f"tried(lambda: {act})" for act in acts)
    told = restricted(f"{{(here := Path({str(tmp_path)!r})): Right.READ}}", tries)
    assert told.split() == ["done", "PermissionError", "PermissionError"]


@needs_landlock
def test_a_single_file_may_be_read_and_a_missing_one_is_passed_over(tmp_path: Path) -> None:
    for name in ("given", "other"):
        (tmp_path / name).touch()
    rights = f"dict.fromkeys([(here := Path({str(tmp_path)!r})) / 'given', here / 'missing'], Right.READ)"
    tries = ", ".join(f"tried((here / {name!r}).read_text)" for name in ("given", "other"))
    assert restricted(rights, tries).split() == ["done", "PermissionError"]


@needs_landlock
def test_a_process_of_several_threads_is_refused() -> None:
    program = """
import threading
from jobs.process.landlock import restrict_files
threading.Thread(target=threading.Event().wait, daemon=True).start()
try:
    restrict_files({})
except RuntimeError as error:
    print(error)
"""
    told = subprocess.check_output([sys.executable, "-c", program], text=True)
    assert told.strip() == "only a process of one thread can be restricted"


def test_rights_of_folders_are_not_asked_for_files() -> None:
    assert landlock._OF_FILES & (Right.READ_DIR | Right.MAKE_REG | Right.REFER | Right.REMOVE_FILE) == 0
