"""Run folders for reading, by the API and the command line: those of the home, or copies from the store."""

from __future__ import annotations

import logging
import shutil
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from obstore.exceptions import BaseError

from jobs.home.home import Home
from jobs.home.object_store import open_object_store
from jobs.home.passing_faults import one_line
from jobs.runs.run_saving import SHOWN
from jobs.runs.run_transfer import bring, run_prefix
from jobs.runs.stored_run import StoredRun

__all__ = ["RunReader", "run_reader"]

FRESH = 1.0  # seconds that a copy counts as new: several requests come at once
AWAY = 10.0  # and while the store is away
MOST = 200  # runs of which copies are kept

log = logging.getLogger(__name__)


class RunReader(Protocol):
    """Finds the files of a run that people look at: its log, course, pictures and report."""

    def folder(self, job_id: str) -> Path:
        """Return a folder that has them, under the names of the run folder; it may be missing."""


@dataclass(frozen=True)
class _HomeReader:
    home: Home

    def folder(self, job_id: str) -> Path:
        return self.home.run(job_id)


class _StoreReader:
    """Keeps copies in the home's folder `shown`; safe to use from several threads."""

    def __init__(self, home: Home) -> None:
        self._store = open_object_store(home.store_url, once=True)  # somebody waits
        self._folder = home.folder / "shown"
        self._copied: dict[str, Mapping[str, str]] = {}  # run -> digest of each copied file
        self._next_look: dict[str, float] = {}
        self._turns: dict[str, threading.Lock] = {}
        self._turn = threading.Lock()

    def folder(self, job_id: str) -> Path:
        folder = self._folder / job_id
        with self._turn:
            turn = self._turns.setdefault(job_id, threading.Lock())
        with turn:
            if time.monotonic() >= self._next_look.get(job_id, 0.0):
                fresh = FRESH
                try:
                    self._copy(job_id, folder)
                except BaseError as error:
                    log.warning("what the store has of %s is not known: %s", job_id, one_line(error))
                    if not folder.is_dir():
                        raise
                    fresh = AWAY
                self._next_look[job_id] = time.monotonic() + fresh
        return folder

    def _copy(self, job_id: str, folder: Path) -> None:
        stored, files = StoredRun(self._store, run_prefix(job_id)), {}
        try:
            head = stored.head()
            files = {} if head is None else {name: head.files[name] for name in SHOWN & head.files.keys()}
            if job_id not in self._copied:  # another process made the copy
                shutil.rmtree(folder, ignore_errors=True)
                with self._turn:
                    self._make_room()
            before = self._copied.get(job_id, {})
            folder.mkdir(parents=True, exist_ok=True)
            bring(stored, {name: file for name, file in files.items() if before.get(name) != file.sha256}, folder)
            for name in before.keys() - files.keys():
                (folder / name).unlink(missing_ok=True)
            self._copied[job_id] = {name: file.sha256 for name, file in files.items()}
        except FileNotFoundError:  # superseded since: the next look finds what took its place
            self._copied.setdefault(job_id, {})

    def _make_room(self) -> None:
        copies = sorted(self._folder.iterdir(), key=lambda path: path.stat().st_mtime) if self._folder.is_dir() else []
        for folder in copies[: max(len(copies) - MOST + 1, 0)]:
            shutil.rmtree(folder, ignore_errors=True)
            self._copied.pop(folder.name, None)
            self._next_look.pop(folder.name, None)
            self._turns.pop(folder.name, None)


def run_reader(home: Home) -> RunReader:
    """Return the reader of the runs of a home."""
    return _StoreReader(home) if home.runs_in_store else _HomeReader(home)
