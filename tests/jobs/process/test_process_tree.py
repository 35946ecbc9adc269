from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from jobs.process.process_tree import THREADS_EACH, Process, ProcessTree, too_many

Poll = Callable[[Callable[[], bool], str], None]

pytestmark = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="the system has no /proc")

# A leader of a session whose child leads another one, and has a child that sleeps; the leader ends the one in between.
LEADER = """
import os, signal, subprocess, sys, time
from jobs.process.process_tree import ProcessTree, keep_orphans
if "keep" in sys.argv:
    keep_orphans()
between = "import subprocess, time; print(subprocess.Popen(['sleep', '1000']).pid, flush=True); time.sleep(1000)"
child = subprocess.Popen([sys.executable, "-c", between], stdout=subprocess.PIPE, text=True, start_new_session=True)
print(child.stdout.readline().strip(), flush=True)
input()
child.kill()
child.wait()
print("orphaned", flush=True)
input()
if "kill" in sys.argv:
    ProcessTree(os.getpid()).kill()
    print("killed", flush=True)
    input()
"""


class Leader:
    def __init__(self, *arguments: str) -> None:
        pipe = subprocess.PIPE
        command = [sys.executable, "-c", LEADER, *arguments]
        self.process = subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True, start_new_session=True)
        self.sleeper = int(self.said())
        self.tree = ProcessTree(self.process.pid)

    def said(self) -> str:
        assert self.process.stdout is not None
        return self.process.stdout.readline().strip()

    def go_on(self) -> str:
        assert self.process.stdin is not None
        self.process.stdin.write("\n")
        self.process.stdin.flush()
        return self.said()

    def has_sleeper(self) -> bool:
        return self.sleeper in {process.pid for process in self.tree.look()}


@pytest.fixture
def lead() -> Iterator[Callable[..., Leader]]:
    leaders: list[Leader] = []

    def lead(*arguments: str) -> Leader:
        leaders.append(Leader(*arguments))
        return leaders[-1]

    yield lead
    for leader in leaders:
        for pid in (leader.process.pid, leader.sleeper):
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        leader.process.communicate()


def is_alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


def test_who_leaves_the_session_is_found(lead: Callable[..., Leader]) -> None:
    leader = lead()
    found = {process.pid: process for process in leader.tree.look()}
    assert len(found) == 3
    assert found[leader.process.pid].session != found[leader.sleeper].session
    assert found[leader.sleeper].threads == 1


def test_who_loses_its_parent_is_found_if_it_was_seen_before(lead: Callable[..., Leader]) -> None:
    seen, unseen = lead(), lead()
    assert seen.has_sleeper()
    assert [leader.go_on() for leader in (seen, unseen)] == ["orphaned", "orphaned"]
    assert seen.has_sleeper()
    assert not unseen.has_sleeper()


def test_or_if_orphans_are_kept(lead: Callable[..., Leader]) -> None:
    leader = lead("keep")
    assert leader.go_on() == "orphaned"
    assert leader.has_sleeper()


def test_all_are_killed(lead: Callable[..., Leader], wait_until: Poll) -> None:
    leader = lead("keep")
    leader.go_on()
    leader.tree.kill()
    assert leader.process.wait() == -signal.SIGKILL
    wait_until(lambda: not is_alive(leader.sleeper), "the end of the sleeper")


def test_a_process_kills_its_own_and_lives(lead: Callable[..., Leader], wait_until: Poll) -> None:
    leader = lead("keep", "kill")
    leader.go_on()
    assert leader.go_on() == "killed"
    wait_until(lambda: not is_alive(leader.sleeper), "the end of the sleeper")


def test_processes_and_their_threads_are_counted() -> None:
    def processes(count: int, threads: int) -> list[Process]:
        return [Process(pid, 1, 1, 1, threads, 0.0, 0) for pid in range(count)]

    assert too_many(processes(10, THREADS_EACH), 10) == ""
    assert (
        too_many(processes(11, 1), 10)
        == "too many processes: 11, limit 10; raise HGS_STAGE_PROCESSES if they are meant"
    )
    assert too_many(processes(2, 5 * THREADS_EACH + 1), 10) == (
        "too many threads: 322, limit 320, 32 for each process of HGS_STAGE_PROCESSES; raise that if they are meant"
    )
