from __future__ import annotations

import asyncio
import json
import os
import subprocess
import sys
import uuid
from pathlib import Path

import pytest

from hgs_core.capture.open import open_capture
from hgs_core.check.capture_check import check_capture
from jobs.process.landlock import landlock_version
from server.captures.check_requests import CaptureCheckRun, CaptureChecks
from server.http.problems import ProblemError
from tests.synthetic import write_capture

FOUND = {
    "cameras": [{"name": "a"}],
    "findings": [],
    "stops": False,
    "frames": [0],
    "width": 64,
    "shown": ["large"],
}


def checks(program: str, longest: float = 600.0) -> CaptureChecks:
    """Checks that run a program of Python in place of `hgs`; it has the capture as argument."""
    return CaptureChecks(lambda capture: [sys.executable, "-c", program, str(capture)], longest)


async def ended(check: CaptureCheckRun) -> CaptureCheckRun:
    while check.ended is None:
        await asyncio.sleep(0.01)
    return check


@pytest.mark.parametrize("status", [0, 2])
def test_what_a_check_found_is_told_also_where_it_stops(status: int) -> None:
    async def scenario() -> None:
        print_it = f"print({json.dumps(json.dumps(FOUND))}); raise SystemExit({status})"
        check = await ended(checks(print_it).start(Path("/a")))
        told = check.to_json()
        assert (told["state"], told["error"]) == ("done", None)
        assert told["found"] == {name: value for name, value in FOUND.items() if name != "shown"}

    asyncio.run(scenario())


@pytest.mark.parametrize(
    ("program", "error"),
    [
        (
            "import sys; sys.exit('a bar\\rhgs: /a: has no two videos; put some there\\n'.replace('\\r', '\\n'))",
            "/a: has no two",
        ),
        ("raise SystemExit(3)", "ended with status 3"),
        ("import os; os.kill(os.getpid(), 9)", "ended with status -9"),
        ("print('no JSON')", "internal server error"),
    ],
)
def test_what_fails_says_why(program: str, error: str) -> None:
    async def scenario() -> None:
        check = await ended(checks(program).start(Path("/a")))
        assert check.state == "failed"
        assert (check.error or "").startswith(error)

    asyncio.run(scenario())


def test_a_check_has_the_limits_of_a_stage(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HGS_STAGE_FILES", "99,initialise=77")
    tell = "import resource; raise SystemExit(resource.getrlimit(resource.RLIMIT_NOFILE)[1])"

    async def scenario() -> None:
        assert (await ended(checks(tell).start(Path("/a")))).error == "ended with status 77"

    asyncio.run(scenario())


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="the system has no /proc")
def test_a_check_with_too_many_processes_is_ended_with_all_of_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HGS_STAGE_PROCESSES", "5")
    asleep = f"600.{uuid.uuid4().int}"  # seconds, by which its processes are found
    multiply = (
        f"import subprocess, time; command = ['sleep', {asleep!r}]\n"
        "for _ in range(6): subprocess.Popen(command, start_new_session=True)\n"
        "time.sleep(600)"
    )

    async def scenario() -> None:
        check = await ended(checks(multiply).start(Path("/a")))
        assert (check.error or "").startswith("stopped: too many processes: ")

    asyncio.run(scenario())
    listed = subprocess.check_output(["ps", "-e", "-o", "args="], text=True).splitlines()
    assert [line for line in listed if line.startswith("sleep ") and asleep in line] == []


def test_a_check_that_takes_too_long_is_ended() -> None:
    async def scenario() -> None:
        check = await ended(checks("import time; time.sleep(600)", longest=0.2).start(Path("/a")))
        assert (check.state, (check.error or "").partition(":")[0]) == ("failed", "stopped")

    asyncio.run(scenario())


def test_checks_run_one_at_a_time_and_once_per_capture(tmp_path: Path) -> None:
    async def scenario() -> None:
        a, b = tmp_path, tmp_path / "b"  # the pipe is in both
        b.mkdir()
        pipe = b / "pipe"
        os.mkfifo(pipe)
        some = checks(f"open({str(pipe)!r}).read(); print({json.dumps(json.dumps(FOUND))})")
        first = some.start(a)
        second = some.start(b)
        assert some.start(a) is first
        while first.state != "running":
            await asyncio.sleep(0.01)
        assert second.state == "waiting"
        for check in (first, second):
            await asyncio.to_thread(pipe.write_text, "")
            assert (await ended(check)).state == "done"
        assert some.get(a) is first
        again = some.start(a)
        assert again is not first
        waits = some.start(b)
        while again.state != "running":
            await asyncio.sleep(0.01)
        await some.close()  # does not wait for anybody to write into the pipe
        assert [one.error for one in (again, waits)] == ["the server stopped"] * 2

    asyncio.run(scenario())


def test_too_many_that_wait_are_refused() -> None:
    async def scenario() -> None:
        some = checks("import time; time.sleep(600)")
        for number in range(20):
            some.start(Path(f"/{number}"))
        try:
            with pytest.raises(ProblemError, match="20 captures are waiting"):
                some.start(Path("/more"))
        finally:
            await some.close()

    asyncio.run(scenario())


def test_the_process_knows_no_secrets(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "s")
    monkeypatch.setenv("HGS_DATABASE_URL", "postgresql://user:password@host/db")

    async def scenario() -> None:
        program = "import os; raise SystemExit(any(n.startswith(('AWS_', 'HGS_DATABASE')) for n in os.environ))"
        assert (await ended(checks(program).start(Path("/a")))).error == "ended with status 0"

    asyncio.run(scenario())


@pytest.mark.skipif(landlock_version() == 0, reason="the kernel has no Landlock")
def test_a_check_reads_its_capture_alone(tmp_path: Path) -> None:
    for name in ("capture", "home"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "file").touch()

    async def scenario() -> None:
        told = []
        for name in ("capture", "home"):
            program = f"open({str(tmp_path / name / 'file')!r}); raise SystemExit(5)"
            told.append((await ended(checks(program).start(tmp_path / "capture"))).error)
        assert told == ["ended with status 5", "ended with status 1"]

    asyncio.run(scenario())


def test_a_check_in_its_sandbox_finds_what_one_without_finds(tmp_path: Path) -> None:
    write_capture(tmp_path / "capture", frames=2)

    async def scenario() -> None:
        check = await ended(CaptureChecks().start(tmp_path / "capture"))
        assert check.error is None
        found = check_capture(open_capture(tmp_path / "capture"), lambda progress: None).to_json()
        assert check.found == json.loads(json.dumps({name: found[name] for name in check.found or {}}))

    asyncio.run(scenario())
