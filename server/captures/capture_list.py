"""The list of captures in the folders that the server may read.

Separate processes open the files (`server.captures.capture_readers`), and only those of new or changed captures.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from server.captures.capture_folders import CaptureFolders
from server.captures.capture_readers import CaptureReaders, ReaderEndedError, answered
from server.http.encodable import encodable
from server.http.problem_error import ProblemError

__all__ = ["CaptureList"]

LOOKED_AT = "is being read; try again in a few seconds"

_PATIENCE = 5.0  # seconds to wait for captures not described yet
_FIND_SECONDS = 60.0  # longest scan of the folders
_SECONDS = 20  # processor time per capture
_WALL_SECONDS = 120.0  # wall time per capture
_UNKNOWN = dict.fromkeys(("frames", "seconds", "picture", "presets"))
_TOGETHER = 16  # captures described by one process
_KEPT_SECONDS = 600.0  # time to remember that a capture crashed its reader: the machine may have been at fault


@dataclass(frozen=True)
class _Known:
    """Description of a capture with these files, valid until a moment in seconds of the monotonic clock."""

    mark: str
    description: dict[str, Any]
    until: float = float("inf")


class CaptureList:
    """Finds and describes the captures; for one event loop."""

    def __init__(self, folders: CaptureFolders, readers: CaptureReaders, patience: float = _PATIENCE) -> None:
        """Read nothing yet; responses wait up to `patience` seconds for new captures."""
        self.folders = folders
        self._readers, self._patience = readers, patience
        self._threads = ThreadPoolExecutor(2, "captures")  # one finds, one describes
        self._known: dict[str, _Known] = {}
        self._wanted: dict[str, dict[str, Any]] = {}  # captures to describe, by path
        self._describing: asyncio.Task[None] | None = None
        self._finding = asyncio.Lock()
        self._next: asyncio.Task[dict[str, Any]] | None = None

    async def describe(self) -> dict[str, Any]:
        """Return the body of `GET /v1/captures`.

        Captures not described within a few seconds have `looking` true. Callers that arrive during a scan share
        the next one.

        Raises:
            ProblemError: 503, the folders cannot be scanned.
        """
        if self._next is None or self._next.done():
            self._next = asyncio.create_task(self._find())
        found = await asyncio.shield(self._next)  # a caller that leaves must not cancel the scan of the others
        self._want(found["captures"])
        patient_until = time.monotonic() + self._patience
        while time.monotonic() < patient_until and any(self._of(one) is None for one in found["captures"]):
            await asyncio.sleep(0.02)
        roots = [{"path": str(folder), "exists": folder.is_dir()} for folder in self.folders.folders]
        captures = [self._told(one) for one in found["captures"]]
        answer: dict[str, Any] = encodable({"captures": captures, "folders": roots, "complete": found["complete"]})
        return answer

    def close(self) -> None:
        """Start no further work; running work ends with the readers."""
        self._threads.shutdown(wait=False, cancel_futures=True)

    async def _find(self) -> dict[str, Any]:
        async with self._finding:
            self._next = None  # later callers may expect newer captures than this scan finds
            return await asyncio.get_running_loop().run_in_executor(self._threads, self._found)

    def _found(self) -> dict[str, Any]:
        try:
            (found,) = self._readers.read("find", self.folders.to_json(), _FIND_SECONDS)
        except ReaderEndedError as error:
            detail = f"the capture folders cannot be read ({error.reason}); try again later"
            raise ProblemError(503, "captures-unavailable", detail, headers={"Retry-After": "30"}) from error
        return found

    def _of(self, found: dict[str, Any]) -> dict[str, Any] | None:
        """Return the description of a capture, if it is still current."""
        known = self._known.get(found["capture"])
        fits = known is not None and known.mark == found["mark"] and time.monotonic() < known.until
        return known.description if fits and known is not None else None

    def _told(self, found: dict[str, Any]) -> dict[str, Any]:
        named = {"capture": found["capture"], "name": found["name"]}
        known = self._of(found)
        if known is not None:
            return named | known | {"looking": False}
        unknown = {"layout": found["layout"], "cameras": found["cameras"], **_UNKNOWN}
        return named | unknown | {"problem": f"{found['name']}: {LOOKED_AT}", "looking": True}

    def _want(self, captures: Sequence[dict[str, Any]]) -> None:
        """Start describing new captures, and forget those that are gone."""
        there = {one["capture"]: one for one in captures}
        for gone in set(self._known) - set(there):
            del self._known[gone]
        self._wanted = {path: one for path, one in there.items() if self._of(one) is None}
        if self._wanted and (self._describing is None or self._describing.done()):
            self._describing = asyncio.create_task(self._describe_wanted())

    async def _describe_wanted(self) -> None:
        while wanted := list(self._wanted.values())[:_TOGETHER]:
            await asyncio.get_running_loop().run_in_executor(self._threads, self._describe, wanted.copy())
            described = {one["capture"] for one in wanted}
            self._wanted = {path: one for path, one in self._wanted.items() if path not in described}

    def _describe(self, wanted: list[dict[str, Any]]) -> None:
        """Describe captures; restart the process after one that ended it."""
        while wanted:
            request = self.folders.to_json() | {"captures": [one["capture"] for one in wanted], "seconds": _SECONDS}
            fresh = True
            try:
                for answer in self._readers.read("describe", request, _WALL_SECONDS):
                    self._keep(wanted.pop(0), answer)
                    fresh = False
                return
            except ReaderEndedError as error:
                if fresh:  # otherwise an earlier capture may be at fault: a new process reads this one
                    self._keep_problem(wanted.pop(0), error)

    def _keep(self, found: dict[str, Any], answer: dict[str, Any]) -> None:
        path = found["capture"]
        try:
            self._known[path] = _Known(found["mark"], answered(answer, Path(path)))
        except (InputError, ProblemError, OSError) as error:
            self._known[path] = _Known(found["mark"], self._problem(found, str(error)))

    def _keep_problem(self, found: dict[str, Any], error: ReaderEndedError) -> None:
        description = self._problem(found, str(error.of(Path(found["capture"]))))
        self._known[found["capture"]] = _Known(found["mark"], description, time.monotonic() + _KEPT_SECONDS)

    def _problem(self, found: dict[str, Any], problem: str) -> dict[str, Any]:
        return {
            "layout": found["layout"],
            "cameras": found["cameras"],
            **_UNKNOWN,
            "problem": " ".join(self.folders.shown(problem).split()),
        }
