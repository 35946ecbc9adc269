"""Runs stages as subprocesses: relays their progress, and ends them when they must end."""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import os
import signal
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from hgs_core.base.own_modules import module_command
from hgs_core.base.progress import Progress
from jobs.home.home import Home
from jobs.home.passing_faults import one_line
from jobs.home.stage_settings import SHOW
from jobs.process.memory_limit import system_kills
from jobs.process.process_tree import ProcessTree
from jobs.process.stage_environment import stage_environment
from jobs.process.stage_outcome import Done, Failed, StageOutcome, Waits, outcome_of, read_outcome, record_of
from jobs.process.stage_silence import Silence
from jobs.process.stage_temporary import temporary_folder

__all__ = ["GRACE", "OwnershipLost", "StageRunner"]

GRACE = 10.0  # seconds between SIGTERM and SIGKILL: time to write a checkpoint
LINE_LIMIT = 1 << 20  # bytes of the longest line a stage may print

log = logging.getLogger(__name__)


class OwnershipLost(Exception):  # noqa: N818 - not an error of the stage
    """Another worker has taken this workflow over; nothing that happens here counts any more. Never retried."""


@dataclass
class _Running:
    process: asyncio.subprocess.Process
    tree: ProcessTree
    silence: Silence
    lost: bool = False
    too_many: str = ""  # processes: in one line


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
        outcome = await self._process(workflow, stage, run, on_progress)
        await self._unless_stopping()
        if outcome is None:
            raise OwnershipLost(workflow)
        return outcome

    async def _process(
        self, name: str, stage: str, run: Path, on_progress: Callable[[Progress], Awaitable[None]]
    ) -> StageOutcome | None:
        """Run one stage to its end; return None if it was abandoned."""
        with temporary_folder() as temporary:
            environment = {**stage_environment(self.home, stage, run), "TMPDIR": str(temporary)}
            return await self._process_in(environment, name, stage, run, on_progress)

    async def _process_in(
        self,
        environment: Mapping[str, str],
        name: str,
        stage: str,
        run: Path,
        on_progress: Callable[[Progress], Awaitable[None]],
    ) -> StageOutcome | None:
        killed_before = system_kills()
        with (run / "stage.log").open("ab") as log:
            process = await asyncio.create_subprocess_exec(
                *module_command("jobs.stage", stage, str(run)),
                stdin=asyncio.subprocess.PIPE,  # closes when this process ends, however it ends
                stdout=asyncio.subprocess.PIPE,
                stderr=log,
                start_new_session=True,  # a group of its own, so that its children end with it
                env=environment,
                limit=LINE_LIMIT,
            )
        tree = ProcessTree(process.pid)
        limits = self.home.limits
        silence = Silence(tree, limits.silence.of(stage), limits.report.of(stage))
        running = self._running[name] = _Running(process, tree, silence)
        watches = (
            asyncio.create_task(_end_with(running)),
            asyncio.create_task(_end_if_silent(running, stage)),
            asyncio.create_task(_end_if_too_many(running, stage, int(limits.processes.of(stage)))),
        )
        publishing: list[asyncio.Task[None]] = []
        publish = lambda: publishing.append(asyncio.create_task(self._publish(_showing(name), running, run)))  # noqa: E731
        try:
            reported = await _relay(running, on_progress, publish)
            status = await process.wait()
        except asyncio.CancelledError:
            _signal(process, signal.SIGTERM)
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(process.wait(), GRACE)
            raise
        finally:
            for watch in watches:
                watch.cancel()
            self.abandon(_showing(name))  # first: it keeps others from publishing
            running.tree.kill()
            await process.wait()
            await asyncio.gather(*publishing, return_exceptions=True)
            del self._running[name]
        if running.lost:
            return None
        if running.too_many:
            return Failed(f"{stage}: {running.too_many}")
        return outcome_of(stage, status, reported, silent=silence.over, killed_before=killed_before)

    async def _publish(self, name: str, running: _Running, run: Path) -> None:
        """Publish the finished part of a stage in a process of its own, and report the result to the stage."""

        async def is_heard(progress: Progress) -> None:
            running.silence.broken()

        try:
            outcome: StageOutcome | None = await self._process(name, SHOW, run, is_heard)
        except OSError as error:  # it could not even be started
            outcome = Waits(one_line(error))
        if outcome is not None and running.process.stdin is not None:
            with contextlib.suppress(ConnectionError):
                running.process.stdin.write(json.dumps(record_of(outcome)).encode() + b"\n")
                await running.process.stdin.drain()

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
            running.tree.kill()

    def stop(self) -> None:
        """Ask all stages to save and end; their outcomes are not recorded. Poll `workflows` for the end."""
        self._stopping = True
        for running in list(self._running.values()):
            _signal(running.process, signal.SIGTERM)

    def kill(self) -> None:
        """Kill all stages at once."""
        self._stopping = True
        for running in list(self._running.values()):
            running.tree.kill()


def _showing(name: str) -> str:
    """Return the workflow name of a stage's publisher."""
    return f"{name} {SHOW}"


async def _relay(
    running: _Running, on_progress: Callable[[Progress], Awaitable[None]], publish: Callable[[], object]
) -> StageOutcome:
    """Pass on progress and requests until stdout ends; return the stage's own report of a failure, `Done` for none."""
    assert running.process.stdout is not None
    reported: StageOutcome = Done()
    async for line in running.process.stdout:
        running.silence.broken()
        message = json.loads(line)
        if "stage" in message:
            await on_progress(Progress(message["stage"], message["done"], message["total"], message["figures"]))
        elif "publish" in message:
            publish()
        else:
            reported = read_outcome(message)
    return reported


async def _end_with(running: _Running) -> None:
    """Kill the processes left behind by a stage: they would keep its stdout open."""
    await running.process.wait()
    running.tree.kill()


async def _end_if_silent(running: _Running, stage: str) -> None:
    """Kill a stage that hangs; it is then run again as one that another signal ended."""
    while not running.silence.over:
        await asyncio.sleep(running.silence.interval)
        running.silence.look()
    log.warning("%s in process %d hangs: killing it", stage, running.process.pid)
    running.tree.kill()


async def _end_if_too_many(running: _Running, stage: str, most: int) -> None:
    """Kill a stage that starts ever more processes, before the machine has no place for others."""
    running.too_many = await running.tree.until_too_many(most)
    log.warning("%s in process %d: %s", stage, running.process.pid, running.too_many)
    running.tree.kill()


def _signal(process: asyncio.subprocess.Process, number: signal.Signals) -> None:
    """Signal the stage and its children, unless they are gone."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, number)
