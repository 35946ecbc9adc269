"""Segments of one run on machines that share no folder: claimed, and handed over, through the store.

Each segment but the first has a head of its own, `runs/<job id>/parts/<number>/head.json` (`jobs.runs.stored_run`). Who
makes the segment puts a new one every five seconds, with its checkpoint; a head that stays the same for twenty is that
of a dead process, and whoever has watched it so long may go on from there. The first segment belongs to the run.
"""

from __future__ import annotations

import contextlib
import functools
import logging
import re
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Self

from obstore.exceptions import BaseError
from obstore.store import ObjectStore

from jobs.home.home import Home
from jobs.home.object_store import open_object_store
from jobs.home.passing_faults import one_line
from jobs.runs.run_transfer import QUIET, RunState, bring, run_prefix
from jobs.runs.shared_segments import Segments
from jobs.runs.stored_captures import StoredCaptures, capture_of
from jobs.runs.stored_run import RunHead, RunTakenError, StoredRun

__all__ = ["StoredSegments", "fetch_for_help", "help_folder", "is_of_segment", "job_of_folder", "parts_prefix"]

BEAT = 5.0  # seconds between two signs of life
SEGMENT_SILENCE = 20.0  # seconds without one after which whoever makes a segment counts as dead
PATIENCE = 240.0  # seconds to hand a segment over in
LOOK = 2.0  # seconds between two looks at the segments of others

_OF_SEGMENT = re.compile(r"(?:segments/|checkpoint-)([1-9]\d*)(?:[/.].*)?")
_FOR_SEGMENT = re.compile(r"(?:masks|points)/(\d+)\..*")

log = logging.getLogger(__name__)


def parts_prefix(job_id: str) -> str:
    """Return where the segments of a job's run lie in the store."""
    return f"{run_prefix(job_id)}/parts"


def help_folder(home: Home, helper: str) -> Path:
    """Return the folder in which a helper of this name works on this machine."""
    return home.folder / "helped" / helper


def job_of_folder(run: Path) -> str:
    """Return the job of a run folder or of a helper's."""
    return run.name.partition("#")[0]


def is_of_segment(run: Path, name: str) -> bool:
    """Return whether a file of a run made segment by segment belongs to a segment that has a head of its own."""
    return _OF_SEGMENT.fullmatch(name) is not None and (run / "segments").is_dir()


def fetch_for_help(home: Home, folder: Path) -> contextlib.ExitStack:
    """Bring the inputs of all segments into a helper's folder; the returned object holds the capture until closed.

    Those of one segment come when that is claimed.

    Raises:
        RunTakenError: the run is gone.
        FileNotFoundError: the run went on meanwhile.
    """
    held, captures, job_id = contextlib.ExitStack(), StoredCaptures(home), job_of_folder(folder)
    stored = StoredRun(open_object_store(home.store_url), run_prefix(job_id))
    head = stored.head()
    if head is None:
        raise RunTakenError(f"{job_id}: the run is gone")
    aside = [name for name in head.files if name in QUIET or name.startswith("scene") or _FOR_SEGMENT.fullmatch(name)]
    files = {name: file for name, file in head.files.items() if name not in aside}
    bring(stored, files, folder, captures.translation())
    capture = capture_of(folder)
    if capture is not None:
        held.enter_context(captures.held(capture))
    return held


class StoredSegments:
    """The segments of one run, as exchanged by the processes that make them (`jobs.runs.shared_segments.Exchange`)."""

    def __init__(
        self, store: ObjectStore, job_id: str, run: Path, segments: Segments, on_lost: Callable[[], object]
    ) -> None:
        """Make segments in the folder `run`; `on_lost` is called from a thread if another process goes on with ours."""
        self._store = store
        self._job_id = job_id
        self._run = run
        self._segments = segments
        self._on_lost = on_lost
        self._seen: dict[int, tuple[str, float]] = {}  # the heads of others, and since when they are the same
        self._next_look = 0.0

    @classmethod
    def of(cls, home: Home, run: Path, segments: Segments, on_lost: Callable[[], object]) -> Self:
        """Return the segments of the run that a folder of this machine is of."""
        return cls(open_object_store(home.store_url), job_of_folder(run), run, segments, on_lost)

    @contextlib.contextmanager
    def claimed(self, number: int, meanwhile: Callable[[], object]) -> Iterator[bool]:
        """Claim a segment, and bring its inputs and checkpoint; when the block ends, hand it over or give it up."""
        state = self._claim(number)
        if state is None:
            yield False
            return
        over = threading.Event()

        def beat() -> None:
            while not over.wait(BEAT):
                try:
                    state.save(always=True)
                    meanwhile()
                except RunTakenError:
                    self._on_lost()
                    return
                except Exception as error:  # raised at the end
                    log.warning("segment %d was not saved: %s", number, one_line(error))

        beating = threading.Thread(target=beat, name="segment", daemon=True)
        beating.start()
        try:
            self._bring_inputs(number)
            yield True
        except BaseException:
            over.set()
            beating.join()
            with contextlib.suppress(Exception):  # then others wait until they believe that we are dead
                state.save(free=True)
            raise
        over.set()
        beating.join()
        _hand_over(state)

    def bring(self) -> bool:
        """Bring the segments that others have made."""
        if time.monotonic() < self._next_look:
            return False
        self._next_look = time.monotonic() + LOOK
        try:
            return self._bring()
        except BaseError as error:
            self._nothing_seen(error)
            return False

    @functools.cached_property
    def _count(self) -> int:
        return self._segments.segment_count(self._run)  # found once: the capture is opened for it

    def _bring(self) -> bool:
        new = False
        for number in range(1, self._count):
            if self._segments.made(self._run, number):
                continue
            stored = self._part(number)
            head = stored.head()
            if head is None:
                continue
            if head.complete:
                # What tells that it is made comes last.
                last = {f"segments/{number}", f"segments/{number}/manifest.json"} & head.files.keys()
                bring(stored, {name: file for name, file in head.files.items() if name not in last}, self._run)
                bring(stored, {name: head.files[name] for name in last}, self._run)
                new = True
            elif self._seen.get(number, ("", 0.0))[0] != head.tag:
                self._seen[number] = head.tag, time.monotonic()
        return new

    def _bring_inputs(self, number: int) -> None:
        """Bring the inputs of this segment alone, where they are not here yet."""
        stored = StoredRun(self._store, run_prefix(self._job_id))
        head = stored.head()
        named = {} if head is None else {n: f for n, f in head.files.items() if _number_of(n, _FOR_SEGMENT) == number}
        bring(stored, {name: file for name, file in named.items() if not (self._run / name).exists()}, self._run)

    def _claim(self, number: int) -> RunState | None:
        stored = self._part(number)
        try:
            before = stored.head()
            if before is None:
                before, head = RunHead(0), stored.create(RunHead(1))
            elif before.complete or not (before.free or self._silent(number, before)):
                return None
            else:
                head = stored.replace(before, RunHead(before.epoch + 1, before.files))
        except RunTakenError:
            return None
        except BaseError as error:
            self._nothing_seen(error)
            return None
        state = RunState(
            stored, self._run, head.epoch, wanted=lambda name: _number_of(name) == number, mark=f".epoch-{number}"
        )
        state.go_on(head, before)
        return state

    def _nothing_seen(self, error: BaseError) -> None:
        """Begin to watch anew: a worker cut off from the store is not dead."""
        log.warning("the segments of others are not known: %s", one_line(error))
        self._seen.clear()

    def _silent(self, number: int, head: RunHead) -> bool:
        tag, since = self._seen.get(number, ("", 0.0))
        return tag == head.tag and time.monotonic() - since > SEGMENT_SILENCE

    def _part(self, number: int) -> StoredRun:
        return StoredRun(self._store, f"{parts_prefix(self._job_id)}/{number}")


def _hand_over(state: RunState) -> None:
    """Save a segment that is made; a store that is away is asked again for some minutes."""
    deadline = time.monotonic() + PATIENCE
    while True:
        try:
            state.save(complete=True)
            return
        except BaseError as error:
            if time.monotonic() >= deadline:
                raise
            log.warning("a segment that is made was not saved: %s", one_line(error))
        time.sleep(BEAT)


def _number_of(name: str, kind: re.Pattern[str] = _OF_SEGMENT) -> int:
    found = kind.fullmatch(name)
    return 0 if found is None else int(found[1])
