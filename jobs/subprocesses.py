"""Runs stages as subprocesses: relays their progress, and ends them when they must end."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import signal
import sys
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from pathlib import Path

from hgs_core.base.progress import Progress
from jobs.home import Home

__all__ = ["GRACE", "OwnershipLost", "StageOutcome", "StageRunner"]

GRACE = 10.0  # seconds between SIGTERM and SIGKILL: time to write a checkpoint
LINE_LIMIT = 1 << 20  # bytes of the longest line a stage may print


class OwnershipLost(Exception):  # noqa: N818 - not an error of the stage
    """Another worker has taken this workflow over; nothing that happens here counts any more. Never retried."""


@dataclass(frozen=True)
class StageOutcome:
    """How a stage ended: `error` is one line, empty on success; `killed` if a signal ended it and not its own code."""

    error: str = ""
    killed: bool = False


@dataclass
class _Running:
    process: asyncio.subprocess.Process
    lost: bool = False


@dataclass
class StageRunner:
    """The stage subprocesses of this worker, by workflow id.

    `run` belongs to one event loop; the other methods may be called from any thread.
    """

    home: Home
    _running: dict[str, _Running] = field(default_factory=dict)
    _stopping: bool = False

    async def run(
        self, workflow: str, stage: str, run: Path, on_progress: Callable[[Progress], Awaitable[None]]
    ) -> StageOutcome:
        """Run one stage to its end. Cancelling this coroutine stops the stage: SIGTERM, 10 s, SIGKILL.

        Raises:
            OwnershipLost: `abandon` was called for this workflow.
        """
        await self._unless_stopping()
        with (run / "stage.log").open("ab") as log:
            process = await asyncio.create_subprocess_exec(
                *(sys.executable, "-m", "jobs.stage", stage, str(run)),
                stdin=asyncio.subprocess.PIPE,  # never written: it closes when this process ends, however it ends
                stdout=asyncio.subprocess.PIPE,
                stderr=log,
                start_new_session=True,  # a group of its own, so that its children end with it
                env={**os.environ, **self.home.environment()},
                limit=LINE_LIMIT,
            )
        running = self._running[workflow] = _Running(process)
        try:
            error = await _relay(process, on_progress)
            status = await process.wait()
        except asyncio.CancelledError:
            _signal(process, signal.SIGTERM)
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(process.wait(), GRACE)
            raise
        finally:
            _signal(process, signal.SIGKILL)
            await process.wait()
            del self._running[workflow]
        await self._unless_stopping()
        if running.lost:
            raise OwnershipLost(workflow)
        return _outcome(stage, status, error)

    async def _unless_stopping(self) -> None:
        """Never return once the worker is about to exit: an outcome would be recorded, where another shall resume."""
        if self._stopping:
            await asyncio.Event().wait()

    def workflows(self) -> list[str]:
        """Return the workflows that have a stage running here."""
        return list(self._running)

    def abandon(self, workflow: str) -> None:
        """Kill the stage of a workflow that this worker no longer owns."""
        running = self._running.get(workflow)
        if running is not None:
            running.lost = True
            _signal(running.process, signal.SIGKILL)

    def stop(self) -> None:
        """Ask all stages to save and end; their outcomes are not recorded. Poll `workflows` for the end."""
        self._stopping = True
        for running in list(self._running.values()):
            _signal(running.process, signal.SIGTERM)

    def kill(self) -> None:
        """Kill all stages at once."""
        self._stopping = True
        for running in list(self._running.values()):
            _signal(running.process, signal.SIGKILL)


async def _relay(process: asyncio.subprocess.Process, on_progress: Callable[[Progress], Awaitable[None]]) -> str:
    """Pass on progress until stdout ends; return the error that the stage named, if any."""
    assert process.stdout is not None
    error = ""
    async for line in process.stdout:
        message = json.loads(line)
        if "error" in message:
            error = message["error"]
        else:
            await on_progress(Progress(message["stage"], message["done"], message["total"], message["figures"]))
    return error


def _outcome(stage: str, status: int, error: str) -> StageOutcome:
    if status == 0:
        return StageOutcome()
    if error:
        return StageOutcome(error)
    if status < 0:
        name = signal.Signals(-status).name
        hint = " (out of memory?)" if -status == signal.SIGKILL else ""
        return StageOutcome(f"{stage}: ended by {name}{hint}", killed=True)
    return StageOutcome(f"{stage}: exit status {status}; see stage.log in the run folder", killed=status == 75)


def _signal(process: asyncio.subprocess.Process, number: signal.Signals) -> None:
    """Signal the stage and its children, unless they are gone."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, number)
