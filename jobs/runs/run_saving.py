"""A worker's runs and their state in the store: claimed and fetched before a stage, saved while it runs and at its end.

Where the home is shared there is nothing to do. A store that is away for a while costs no training: what could not be
saved is saved the next time. Only the end of a stage waits for it, since another machine would look for its results.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import threading
import time
from collections.abc import AsyncIterator, Callable
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import assert_never

from jobs.home.home import Home
from jobs.home.object_store import open_object_store
from jobs.home.passing_faults import one_line, passing_fault
from jobs.process.stage_outcome import Done, Failed, Waits
from jobs.runs.run_transfer import QUIET, RunState, run_prefix
from jobs.runs.stored_captures import StoredCaptures, capture_of, is_upload
from jobs.runs.stored_run import RunHead, RunTakenError, StoredRun
from jobs.runs.stored_segments import is_of_segment, parts_prefix

__all__ = ["SHOWN", "RunSaving"]

LOOK = 1.0  # seconds between two looks whether there is anything to save
QUIET_INTERVAL = 10.0  # seconds after which a log is saved that alone has grown
AGAIN = 5.0  # seconds after which a save that failed is tried again

SHOWN = QUIET | {"run.json", "check.json", "train.json", "eval.json", "report.html", "scene/thumbnail.jpg"}
"""The files kept of a job's run after publication, for people to look at."""

log = logging.getLogger(__name__)

Attempt = tuple[str, int]  # job id, attempt
Saved = Done | Failed | Waits  # the outcomes of a claim or a save


@dataclass
class _Claim:
    epoch: int
    state: RunState | None = None  # None: not claimed yet
    taken: bool = False  # another process has the run
    held: ExitStack = field(default_factory=ExitStack)  # the capture


class RunSaving:
    """The attempts that this worker works on; may be called from any thread, `claim` and `meanwhile` from the loop."""

    def __init__(self, home: Home) -> None:
        self._home = home
        self._store = open_object_store(home.store_url) if home.runs_in_store else None
        self._claims: dict[Attempt, _Claim] = {}

    def begin(self, attempt: Attempt, epoch: int) -> None:
        """Note under which epoch this worker has taken an attempt."""
        self._claims[attempt] = _Claim(epoch)

    def end(self, attempt: Attempt) -> None:
        """Forget an attempt."""
        claim = self._claims.pop(attempt, None)
        if claim is not None:
            claim.held.close()

    async def claim(self, attempt: Attempt) -> Saved:
        """Claim the run and restore its folder here; the outcome gives the reason of a refusal, if any."""
        if self._store is None:
            return Done()
        claim = self._claims[attempt]
        if claim.state is not None and not claim.taken:
            return Done()
        captures, run = StoredCaptures(self._home), self._home.run(attempt[0])
        stored = StoredRun(self._store, run_prefix(attempt[0]))
        state = RunState(
            stored, run, claim.epoch, wanted=lambda name: not is_of_segment(run, name), translate=captures.translation()
        )

        def have() -> None:
            state.claim()
            claim.held.close()
            claim.held.enter_context(captures.held(self.capture(attempt[0], Path("/"))))
            keep_findings_in(run)

        outcome = await asyncio.to_thread(_outcome_of, have)
        if isinstance(outcome, Done):
            claim.state, claim.taken = state, False
        return outcome

    def path_of_capture(self, attempt: Attempt) -> Path | None:
        """Return where the capture must lie on this machine before its run is fetched; None for none, or if unknown."""
        claim = self._claims.get(attempt)
        if self._store is None or claim is None or claim.state is not None:
            return None
        try:
            stored = StoredRun(self._store, run_prefix(attempt[0]))
            head = stored.head()
            spec = json.loads(b"{}" if head is None else stored.read(head.files["run.json"]))
            is_fetched = spec.get("edited") or is_upload(spec["capture"])
            return None if is_fetched else Path(spec["capture"])
        except Exception as error:  # the claim will say more
            log.info("the capture of %s is not known yet: %s", attempt[0], one_line(error))
            return None

    def capture(self, job_id: str, submitted: Path) -> Path:
        """Return where this machine has the capture of a job, that was submitted as `submitted`."""
        if self._store is None:
            return submitted
        return capture_of(self._home.run(job_id)) or submitted

    @contextlib.asynccontextmanager
    async def meanwhile(self, attempt: Attempt, on_taken: Callable[[], object]) -> AsyncIterator[None]:
        """Save changes now and then; call `on_taken` if another process has the run."""
        saving = asyncio.create_task(self._save_again_and_again(attempt, on_taken))
        try:
            yield
        except asyncio.CancelledError:  # job cancelled: the state may help a retry, but nobody waits for it
            asyncio.get_running_loop().run_in_executor(None, self._save, attempt)
            raise
        finally:
            saving.cancel()

    async def save(self, attempt: Attempt) -> Saved:
        """Save all that has changed; the outcome says why that failed, if it did."""
        return await asyncio.to_thread(self._save, attempt)

    def taken(self, attempt: Attempt) -> bool:
        """Return whether another process was found to have the run."""
        return attempt in self._claims and self._claims[attempt].taken

    def save_all(self, seconds: float) -> None:
        """Save all runs, for at most so long: the worker ends."""
        threads = [threading.Thread(target=self._save, args=(attempt,), daemon=True) for attempt in list(self._claims)]
        deadline = time.monotonic() + seconds
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(max(deadline - time.monotonic(), 0.0))

    def complete(self, attempt: Attempt) -> None:
        """Drop the superfluous files of a published run; failures are left to `hgs gc`."""
        if self._store is None:
            return
        stored, epoch = StoredRun(self._store, run_prefix(attempt[0])), self._claims[attempt].epoch
        parts = StoredRun(self._store, parts_prefix(attempt[0]))
        try:
            before = stored.head()
            if before is not None and before.epoch <= epoch:
                shown = {name: file for name, file in before.files.items() if name in SHOWN}
                stored.remove_superseded(stored.replace(before, RunHead(epoch, shown, complete=True)))
                parts.remove()
        except Exception as error:
            log.warning("the run of %s was not cleared: %s", attempt[0], one_line(error))

    def _save(self, attempt: Attempt) -> Saved:
        claim = self._claims.get(attempt)
        if claim is None or claim.state is None:
            return Done()
        outcome = _outcome_of(claim.state.save)
        claim.taken = claim.taken or outcome is _TAKEN
        return outcome

    async def _save_again_and_again(self, attempt: Attempt, on_taken: Callable[[], object]) -> None:
        claim = self._claims.get(attempt)
        if claim is None or claim.state is None:
            return
        next_quiet = time.monotonic() + QUIET_INTERVAL
        before: frozenset[str] | None = None
        while True:
            if before is not None:
                await asyncio.sleep(LOOK)
            try:
                names, changed = await asyncio.to_thread(claim.state.look)
            except OSError as error:
                log.warning("%s: its run folder cannot be looked at: %s", attempt[0], one_line(error))
                names, changed = frozenset(), frozenset()
            # What a stage writes as several files belongs together: not while names still come.
            still, before = names == before, names
            if not still or not (changed - QUIET or (changed and time.monotonic() >= next_quiet)):
                continue
            outcome = await asyncio.to_thread(self._save, attempt)
            next_quiet = time.monotonic() + QUIET_INTERVAL
            if claim.taken:
                log.warning("%s: %s", attempt[0], _TAKEN.reason)
                on_taken()
                return
            match outcome:
                case Waits(reason) | Failed(reason):
                    log.warning("%s was not saved: %s", attempt[0], reason)
                    await asyncio.sleep(AGAIN)
                case Done():
                    pass
                case _:
                    assert_never(outcome)


def keep_findings_in(run: Path) -> None:
    """Make a run keep the cameras that it finds in its own folder: the capture's is not everybody's."""
    (run / "found").mkdir(exist_ok=True)


_TAKEN = Waits("another process has taken this run over")


def _outcome_of(move: Callable[[], None]) -> Saved:
    try:
        move()
    except RunTakenError:
        return _TAKEN
    except Exception as error:
        fault = passing_fault(error)
        if fault is None:
            return Failed(one_line(error))
        return Waits(fault.reason, fault.cause)
    return Done()
