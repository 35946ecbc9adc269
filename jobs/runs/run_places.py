"""Where the run folders of jobs lie: in the home that all share, or in the store, with copies on the machines."""

from __future__ import annotations

from collections.abc import Callable, Collection, Container, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Protocol

import obstore

from jobs.home.home import Home
from jobs.home.object_store import open_object_store
from jobs.runs.retention import folder_bytes
from jobs.runs.run_transfer import RunState, run_prefix
from jobs.runs.run_trash import empty_trash, throw_away, trash
from jobs.runs.stored_captures import StoredCaptures
from jobs.runs.stored_run import StoredRun

__all__ = ["RunPlace", "RunsInHome", "RunsInStore", "run_place"]

_YOUNGEST = timedelta(hours=1)  # runs of no job that are younger stay: their jobs may be about to be made

Known = Callable[[Collection[str]], Container[str]]
"""Returns those of some ids that are jobs'."""


class RunPlace(Protocol):
    """The run folders of jobs, apart from the work on them."""

    def submitted(self, job_id: str) -> None:
        """Keep the run folder of a job that is about to be queued."""

    def remove(self, job_id: str) -> None:
        """Remove a finished job's run at once, as far as anybody can see.

        Raises:
            InputError: a process works on the run.
            OSError: it cannot be moved.
        """

    def removed(self, job_id: str) -> None:
        """Remove the remains of `remove`."""

    def sizes(self, job_ids: Collection[str]) -> Mapping[str, int]:
        """Return how many bytes the runs of these jobs take."""

    def left_over(self, known: Known, *, delete: bool) -> int:
        """Return the bytes of folders without a job; with `delete` remove them. `known` returns the existing jobs."""


@dataclass(frozen=True)
class RunsInHome:
    """The run folders are all there is."""

    home: Home

    def submitted(self, job_id: str) -> None:
        """Do nothing: the folder is where it is looked for."""

    def remove(self, job_id: str) -> None:
        """Move the folder away."""
        throw_away(self.home, job_id)

    def removed(self, job_id: str) -> None:
        """Remove the files of the folder."""
        empty_trash(self.home, job_id)

    def sizes(self, job_ids: Collection[str]) -> Mapping[str, int]:
        """Return the bytes of the folders' files."""
        return {job_id: folder_bytes(self.home.run(job_id)) for job_id in job_ids}

    def left_over(self, known: Known, *, delete: bool) -> int:
        """Finish interrupted removals."""
        freed = 0
        for job_id in trash(self.home):
            freed += folder_bytes(self.home.folder / "trash" / job_id)
            if delete:
                empty_trash(self.home, job_id)
        return freed


class RunsInStore:
    """The store has every run; folders on machines are copies."""

    def __init__(self, home: Home) -> None:
        self._home = home
        self._store = open_object_store(home.store_url)

    def submitted(self, job_id: str) -> None:
        """Bring the folder to the store, and remove it here: it may be a worker's next, and then comes back."""
        translate = StoredCaptures(self._home).translation()
        RunState(self._run(job_id), self._home.run(job_id), 0, translate=translate).create()
        throw_away(self._home, job_id)
        empty_trash(self._home, job_id)

    def remove(self, job_id: str) -> None:
        """Remove the run; a process that still saves it finds it gone."""
        self._run(job_id).remove()

    def removed(self, job_id: str) -> None:
        """Do nothing: each worker looks after its copies."""

    def sizes(self, job_ids: Collection[str]) -> Mapping[str, int]:
        """Return the bytes of the runs' objects, from one listing of all."""
        found = self._listed()
        return {job_id: found[job_id][0] if job_id in found else 0 for job_id in job_ids}

    def left_over(self, known: Known, *, delete: bool) -> int:
        """Remove runs without a job: never queued, deleted, or written late."""
        before, freed = datetime.now(UTC) - _YOUNGEST, 0
        found = self._listed()
        jobs = known(found)  # queried last: a run is older than its job
        for job_id, (size, newest) in found.items():
            if job_id not in jobs and newest < before:
                freed += size
                if delete:
                    self._run(job_id).remove()
        return freed

    def _run(self, job_id: str) -> StoredRun:
        return StoredRun(self._store, run_prefix(job_id))

    def _listed(self) -> dict[str, tuple[int, datetime]]:
        """Return the bytes of all runs, and when each was last written."""
        found: dict[str, tuple[int, datetime]] = {}
        for page in obstore.list(self._store, prefix="runs"):
            for item in page:
                job_id = item["path"].split("/")[1]
                size, newest = found.get(job_id, (0, item["last_modified"]))
                found[job_id] = size + item["size"], max(newest, item["last_modified"])
        return found


def run_place(home: Home) -> RunPlace:
    """Return where the runs of a home lie."""
    return RunsInStore(home) if home.runs_in_store else RunsInHome(home)
