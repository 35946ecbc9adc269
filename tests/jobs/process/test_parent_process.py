from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator

import pytest

CHILD = """
import os, sys, time
from jobs.process.parent_process import when_parent_is_gone
when_parent_is_gone(lambda: os._exit(70))
print("ready", flush=True)
time.sleep({seconds})
"""

# Starts a child whose stdin is a pipe of its own and whose stdout is shared, and waits to be killed.
PARENT = """
import subprocess, sys, time
child = subprocess.Popen([sys.executable, "-c", sys.argv[1]], stdin=subprocess.PIPE, stdout=sys.stdout)
time.sleep(600)
"""

Child = subprocess.Popen[bytes]


@pytest.fixture
def child() -> Iterator[Child]:
    """A process that would sleep for ten minutes, and is ready."""
    with subprocess.Popen(
        [sys.executable, "-c", CHILD.format(seconds=600)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"ready\n"
        yield process
        process.kill()


def test_lines_before_that_are_heard() -> None:
    child = CHILD.format(seconds=600).replace("(70)", "(70), lambda line: print(line, flush=True)")
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", child], stdin=pipe, stdout=pipe) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"ready\n"
        assert process.communicate(b"one\ntwo\n")[0].splitlines() == [b"b'one'", b"b'two'"]


def test_the_end_is_noticed_also_after_a_line_that_failed() -> None:
    child = CHILD.format(seconds=600).replace("(70)", "(70), lambda line: 1 / 0")
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", child], stdin=pipe, stdout=pipe, stderr=pipe) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"ready\n"
        assert b"ZeroDivisionError" in process.communicate(b"one\n")[1]
        assert process.returncode == 70


def test_the_action_comes_when_stdin_closes(child: Child) -> None:
    assert child.stdin is not None
    child.stdin.close()
    assert child.wait() == 70


def test_what_arrives_on_stdin_is_no_end(child: Child) -> None:
    assert child.stdin is not None
    child.stdin.write(b"word\n" * 2000)  # more than one read takes
    child.stdin.flush()
    with pytest.raises(subprocess.TimeoutExpired):
        child.wait(0.5)


def test_a_killed_parent_is_gone_too() -> None:
    with subprocess.Popen([sys.executable, "-c", PARENT, CHILD.format(seconds=600)], stdout=subprocess.PIPE) as parent:
        assert parent.stdout is not None
        assert parent.stdout.readline() == b"ready\n"
        parent.kill()
        assert parent.stdout.read() == b""  # returns when the child, which holds the pipe too, has ended


def test_a_process_that_has_done_its_work_ends_with_stdin_open() -> None:
    """The waiting thread is in the way of no shutdown."""
    with subprocess.Popen(
        [sys.executable, "-c", CHILD.format(seconds=0)], stdin=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        assert process.stderr is not None
        assert (process.wait(), process.stderr.read()) == (0, b"")
