"""The history of a soak: every request of its clients with its answer, one JSON line each."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any

__all__ = ["Act", "Event", "History", "read_history"]


class Act(StrEnum):
    """The kinds of requests; those that change nothing are observations."""

    SUBMIT = "submit"  # target: idempotency key; answer: the job
    SEE = "see"  # target: job; answer: the job
    CANCEL = "cancel"
    RETRY = "retry"
    DELETE_JOB = "delete job"
    BEGIN_UPLOAD = "begin upload"  # target: name; answer: the upload
    SEND = "send"  # target: address of a file; answer: its offset
    ASK_OFFSET = "ask offset"
    FINISH_UPLOAD = "finish upload"  # target: name; request: digests by path; answer: the capture
    DELETE_UPLOAD = "delete upload"  # target: capture
    READ_SCENE = "read scene"  # target: scene; answer: digest of its manifest
    RENAME = "rename"
    DELETE_SCENE = "delete scene"
    PUBLISH = "publish"
    WATCH = "watch"  # answer: figures of the viewer
    ADD_KEY = "add key"  # target: name
    USE_KEY = "use key"
    REVOKE_KEY = "revoke key"
    FAULT = "fault"  # target: its kind


@dataclass(frozen=True)
class Event:
    """One request and its answer; status 0 where none came."""

    act: Act
    target: str
    status: int = 200
    answer: dict[str, Any] = field(default_factory=dict)
    request: dict[str, Any] = field(default_factory=dict)
    began: float = 0.0  # seconds since the start of the soak
    ended: float = 0.0
    client: str = ""

    @property
    def acknowledged(self) -> bool:
        """Whether the service has promised it."""
        return 200 <= self.status < 300

    @property
    def possible(self) -> bool:
        """Whether it may have happened: it was acknowledged, or nobody knows."""
        return self.acknowledged or self.status == 0 or self.status >= 500


class History:
    """A history on its way into a file; safe to use from several threads."""

    def __init__(self, file: Path) -> None:
        """Begin a new one."""
        self._file = file.open("w", buffering=1)
        self._lock = threading.Lock()
        self._start = time.monotonic()

    @property
    def now(self) -> float:
        """Seconds since the beginning."""
        return time.monotonic() - self._start

    def note(self, event: Event) -> Event:
        """Append an event and return it."""
        line = json.dumps(asdict(event))
        with self._lock:
            self._file.write(line + "\n")
        return event

    def close(self) -> None:
        """End the file."""
        with self._lock:
            self._file.close()


def read_history(file: Path) -> Iterator[Event]:
    """Yield the events of a file in the order of their answers."""
    for line in file.read_text().splitlines():
        read = json.loads(line)
        yield Event(**{**read, "act": Act(read["act"])})
