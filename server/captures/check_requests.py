"""Checks of captures requested by clients before they submit a job.

A check runs as `hgs check` in its own process, one at a time, since it takes seconds to minutes of processor time and
imports torch.
"""

from __future__ import annotations

import asyncio
import json
import logging
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from hgs_core.base.own_modules import module_command
from jobs.home.home import Home
from jobs.process.process_tree import ProcessTree
from jobs.process.stage_environment import without_secrets
from server.http.problems import ProblemError

__all__ = ["CaptureCheckRun", "CaptureChecks"]

_STAGE = "initialise"  # the stage of a job that has the same limits
_LONGEST = 1800.0  # longest duration of a check, seconds
_MOST_WAITING = 20
_MOST_KEPT = 200  # captures with a remembered check
_SHOWN = ("cameras", "findings", "stops", "frames", "width")  # fields sent to clients

log = logging.getLogger("hgs.server")


@dataclass
class CaptureCheckRun:
    """The check of one capture."""

    capture: Path
    state: Literal["waiting", "running", "done", "failed"] = "waiting"
    found: dict[str, Any] | None = None
    error: str | None = None  # one line, if it failed
    began: float = field(default_factory=time.monotonic)
    ended: float | None = None

    def end(self, error: str | None) -> None:
        """Record the end of the check; `error` is one line if it failed."""
        self.state, self.error, self.ended = "failed" if error else "done", error, time.monotonic()

    def to_json(self) -> dict[str, Any]:
        """Return the check object of docs/upload.md."""
        return {
            "capture": str(self.capture),
            "state": self.state,
            "found": self.found,
            "error": self.error,
            "seconds": round((self.ended or time.monotonic()) - self.began, 1),
        }


def _command(capture: Path) -> list[str]:
    return module_command("server.cli", "check", str(capture), "--json", "-")


class CaptureChecks:
    """The checks of one server; for its event loop."""

    def __init__(self, command: Callable[[Path], list[str]] = _command, longest: float = _LONGEST) -> None:
        """Start nothing yet; tests pass a `command` of their own."""
        self._command = command
        self._longest = longest
        self._checks: OrderedDict[Path, CaptureCheckRun] = OrderedDict()
        self._tasks: set[asyncio.Task[None]] = set()
        self._one = asyncio.Semaphore(1)

    def get(self, capture: Path) -> CaptureCheckRun | None:
        """Return the last check of a capture, if it is remembered."""
        return self._checks.get(capture)

    def start(self, capture: Path) -> CaptureCheckRun:
        """Start a check and return it, or return the running one of this capture.

        Raises:
            ProblemError: 503, too many checks are waiting.
        """
        before = self._checks.get(capture)
        if before is not None and before.ended is None:
            return before
        if len(self._tasks) >= _MOST_WAITING:
            detail = f"{len(self._tasks)} captures are waiting to be checked; try again later"
            raise ProblemError(503, "checks-waiting", detail, headers={"Retry-After": "30"})
        check = self._checks[capture] = CaptureCheckRun(capture)
        self._checks.move_to_end(capture)
        finished = [path for path, one in self._checks.items() if one.ended is not None]
        for path in finished[: max(0, len(self._checks) - _MOST_KEPT)]:
            del self._checks[path]
        task = asyncio.create_task(self._run(check))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return check

    async def close(self) -> None:
        """Stop all checks."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        for check in self._checks.values():
            if check.ended is None:  # still waiting
                check.end("the server stopped")

    async def _run(self, check: CaptureCheckRun) -> None:
        try:
            async with self._one:
                check.state, check.began = "running", time.monotonic()
                check.end(await self._process(check))
        except asyncio.CancelledError:
            check.end("the server stopped")
            raise
        except Exception:
            log.exception("cannot check capture %s", check.capture)
            check.end("internal server error; see the server's log")

    async def _process(self, check: CaptureCheckRun) -> str | None:
        """Run the check and keep its result; return the error, if any."""
        pipe = asyncio.subprocess.PIPE
        process = await asyncio.create_subprocess_exec(
            *module_command("jobs.process.limited", _STAGE, str(check.capture)),
            *self._command(check.capture),
            stdin=asyncio.subprocess.DEVNULL,
            stdout=pipe,
            stderr=pipe,
            env=without_secrets(),
            start_new_session=True,
        )
        tree, limit = ProcessTree(process.pid), int(Home.from_environment().limits.processes.of(_STAGE))
        ended, crowded = asyncio.create_task(process.communicate()), asyncio.create_task(tree.until_too_many(limit))
        try:
            await asyncio.wait({ended, crowded}, timeout=self._longest, return_when=asyncio.FIRST_COMPLETED)
            if crowded.done():
                return f"stopped: {crowded.result()}"
            if not ended.done():
                return f"stopped: it took longer than {self._longest:.0f} s; use hgs check on the server"
            output, errors = ended.result()
        finally:
            crowded.cancel()
            tree.kill()
            await asyncio.gather(ended, crowded, return_exceptions=True)
        if output.strip():  # also after exit status 2, which means that the capture cannot be trained
            found = json.loads(output)
            check.found = {name: found[name] for name in _SHOWN}
            return None
        told = errors.decode(errors="replace")
        log.warning("check of capture %s: %s", check.capture, told[-4000:])
        return _last_line(told) or f"ended with status {process.returncode}"


def _last_line(text: str) -> str:
    """Return the line with the error message of `hgs`."""
    lines = [line for line in text.splitlines() if line.startswith("hgs: ")]
    return lines[-1].removeprefix("hgs: ")[:2000] if lines else ""
