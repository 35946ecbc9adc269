"""The readiness of this machine for a job: the home, room on its disk, the store, the capture.

A stage that fails while one of them is missing is not to blame, and a machine that misses one takes no job.
"""

from __future__ import annotations

import errno
import os
import shutil
import threading
import time
from dataclasses import dataclass
from pathlib import Path

from obstore.exceptions import BaseError

from jobs.artifacts.artifact_store import ArtifactStore
from jobs.home.home import Home
from jobs.home.home_identity import HomeIdentity
from jobs.home.passing_faults import Cause, one_line, passing_fault
from jobs.process.lasting_thread import lasting_thread

__all__ = ["Missing", "Surroundings"]

# Bytes left on a disk that counts as full: libraries hide the error, and remove what they could not write.
FULL = 1 << 20
CAPTURE_BACKOFF = 60.0  # seconds
STORE_INTERVAL = 10.0  # seconds between two looks at the store
STORE_HANGS = 10.0  # seconds after which a look that has not ended says enough


@dataclass(frozen=True)
class Missing:
    """A lack of this machine, in one line."""

    cause: Cause
    reason: str


class Surroundings:
    """This machine's view of the home's folder, its disk, the store and captures; methods may block on a disk."""

    def __init__(self, home: Home, identity: HomeIdentity) -> None:
        self._home = home
        self._identity = identity
        self._store: Missing | None = None  # result of the last look
        self._looked = False
        self._looking_since: float | None = None
        self._missed: tuple[Path, float] | None = None  # the last capture that `of_job` did not see, and when

    def watch_store(self) -> None:
        """Begin to look at the store every ten seconds, in a thread: one that hangs takes seconds to be found out."""
        lasting_thread("store", self._watch).start()

    def of_machine(self) -> Missing | None:
        """Return the lack of this machine for any job, the store as `watch_store` last saw it; None if ready.

        A capture that `of_job` did not see counts for a minute while it stays away: another machine may see it, or it
        may be gone for good.
        """
        if lacking := self.home():
            return lacking
        began = self._looking_since
        if began is not None and time.monotonic() - began > STORE_HANGS:
            return Missing(Cause.STORE, "the store fails: it does not answer")
        return self._store or self._missed_capture()

    def of_job(self, capture: Path) -> Missing | None:
        """Return the lack of this machine for the stages of a job before its publication; None if ready."""
        if lacking := self.home():
            return lacking
        lacking = _capture(capture)
        if lacking is not None:
            self._missed = capture, time.monotonic()
        return lacking

    def _missed_capture(self) -> Missing | None:
        missed = self._missed
        if missed is None or time.monotonic() - missed[1] > CAPTURE_BACKOFF:
            return None
        lacking = _capture(missed[0])
        if lacking is None:
            self._missed = None
        return lacking

    def store(self) -> Missing | None:
        """Look whether the store answers, for half a minute at most; a dead file server may take for ever."""
        try:
            ArtifactStore(self._home.store_url, once=True).scene_entry("no-such-scene")
        except (BaseError, OSError, ValueError) as error:
            fault = passing_fault(error)
            return Missing(Cause.STORE, fault.reason if fault else f"the store fails: {one_line(error)}")
        return None

    def is_back(self, cause: Cause, capture: Path) -> bool:
        """Return whether the cause of a job's wait is gone on this machine."""
        match cause:
            case Cause.STORE:
                return self._looked and self._store is None
            case Cause.CAPTURE:
                return _capture(capture) is None
            case Cause.HOME | Cause.DISK:
                return self.home() is None

    def home(self) -> Missing | None:
        """Return whether the home or room on its disk is missing; None if neither."""
        mismatch = self._identity.mismatch()
        if mismatch is not None:
            return Missing(Cause.HOME, one_line(mismatch))
        try:
            if shutil.disk_usage(self._home.folder).free < FULL:
                return Missing(Cause.DISK, f"{self._home.folder}: {os.strerror(errno.ENOSPC)}")
        except OSError as error:
            return Missing(Cause.HOME, f"{self._home.folder}: the home cannot be reached ({error.strerror})")
        return None

    def _watch(self) -> None:
        pause = threading.Event()
        while True:
            self._looking_since = time.monotonic()
            self._store = self.store()
            self._looking_since, self._looked = None, True
            pause.wait(STORE_INTERVAL)


def _capture(capture: Path) -> Missing | None:
    try:
        if capture.is_dir() and not any(capture.iterdir()):
            return Missing(Cause.CAPTURE, f"{capture}: the capture's folder is empty; is it mounted?")
        capture.stat()
    except OSError as error:
        return Missing(Cause.CAPTURE, f"{capture}: the capture cannot be reached ({error.strerror})")
    return None
