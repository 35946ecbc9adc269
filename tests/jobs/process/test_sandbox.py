from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from jobs.process import sandbox
from jobs.process.landlock import landlock_version
from jobs.process.sandbox import missing_from_sandbox, with_links

needs_sandbox = pytest.mark.skipif(landlock_version() < 6, reason=missing_from_sandbox() or "the kernel has it all")


def tried(readable: Path, writable: Path, *acts: str) -> list[str]:
    """Return how each act ended, an expression of Python, in a process in the sandbox."""
    program = f"""
import json, os, socket, subprocess, sys
from pathlib import Path
from jobs.process.sandbox import enter_sandbox
enter_sandbox([Path({str(readable)!r})], [Path({str(writable)!r})])
def tried(act):
    try:
        act()
    except (OSError, subprocess.CalledProcessError) as error:
        return type(error).__name__
    return "done"
print(json.dumps([{", ".join(f"tried(lambda: {act})" for act in acts)}]))
"""
    found: list[str] = json.loads(subprocess.check_output([sys.executable, "-P", "-c", program]))
    return found


@pytest.fixture
def places(tmp_path: Path) -> dict[str, Path]:
    found = {name: tmp_path / name for name in ("capture", "run", "home")}
    for folder in found.values():
        folder.mkdir()
        (folder / "file").write_text("text")
    return found


@needs_sandbox
def test_files_outside_are_neither_read_nor_written(places: dict[str, Path]) -> None:
    acts = [f"Path({str(places[name] / 'file')!r}).{act}" for name in places for act in ("read_text()", "touch()")]
    acts += [f"Path({str(places['home'])!r}, 'new').touch()", "Path('/etc/shadow').read_text()", "os.listdir('/root')"]
    told = tried(places["capture"], places["run"], *(act.replace("touch()", "open('a')") for act in acts))
    assert told == ["done", "PermissionError", "done", "done", *["PermissionError"] * 5]


@needs_sandbox
def test_tcp_is_refused(places: dict[str, Path]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        address = listening.getsockname()
        told = tried(
            places["capture"],
            places["run"],
            f"socket.create_connection({address!r})",
            "socket.create_server(('127.0.0.1', 0))",
        )
    assert told == ["PermissionError", "PermissionError"]


@needs_sandbox
def test_other_processes_are_out_of_reach(places: dict[str, Path]) -> None:
    acts = [f"open('/proc/{os.getpid()}/environ', 'rb').read()", f"os.kill({os.getpid()}, 0)"]
    assert tried(places["capture"], places["run"], *acts) == ["PermissionError", "PermissionError"]


@needs_sandbox
def test_programs_that_it_starts_are_in_the_sandbox_too(places: dict[str, Path]) -> None:
    programs = [f"open({str(places[name] / 'file')!r})" for name in ("capture", "home")]
    acts = [f"subprocess.run([sys.executable, '-c', {program!r}], check=True)" for program in programs]
    assert tried(places["capture"], places["run"], *acts) == ["done", "CalledProcessError"]


def test_links_of_a_capture_are_followed_once(tmp_path: Path) -> None:
    capture, elsewhere = tmp_path / "capture", tmp_path / "elsewhere"
    for folder in (capture / "videos", elsewhere):
        folder.mkdir(parents=True)
    (capture / "videos" / "a.mp4").symlink_to(elsewhere / "a.mp4")
    (capture / "loop").symlink_to(capture)
    found = list(with_links(capture))
    assert found[0] == capture
    assert set(found) == {capture, elsewhere / "a.mp4"}


@pytest.mark.parametrize(
    ("version", "words"),
    [(0, "no sandbox: this kernel has no Landlock"), (3, "TCP connections"), (5, "signals"), (6, ""), (7, "")],
)
def test_what_a_kernel_lacks_is_one_line(monkeypatch: pytest.MonkeyPatch, version: int, words: str) -> None:
    monkeypatch.setattr(sandbox, "landlock_version", lambda: version)
    told = missing_from_sandbox()
    assert bool(told) == bool(words)
    assert words in told
    assert "\n" not in told
