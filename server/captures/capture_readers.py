"""Reader processes for the API: their results, and the error to report when a file ends one."""

from __future__ import annotations

import contextlib
import json
import logging
import os
import signal
import subprocess
import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import IO, Any

from hgs_core.base.errors import InputError
from hgs_core.base.own_modules import module_command
from jobs.home.home import Home
from jobs.process.process_tree import ProcessTree
from jobs.process.stage_environment import without_secrets
from server.http.problem_error import ProblemError

__all__ = ["NOTE_BYTES", "CaptureReaders", "ReaderEndedError", "answered"]

NOTE_BYTES = 4096  # longest path of a reader's last file

_CURE = "export the file again, or leave it out"
_LONGEST_ANSWER = 64 << 20  # bytes
_LOGGED = 4000  # bytes of a reader's stderr

log = logging.getLogger("hgs.server")


class ReaderEndedError(Exception):
    """A reader ended before it had finished, because of a file or a limit."""

    def __init__(self, file: str, reason: str) -> None:
        """Keep the path of the file opened last, or "", and the reason for the user."""
        self.file, self.reason = file, reason
        super().__init__(f"{file}: {reason}")

    def of(self, capture: Path) -> InputError:
        """Return the error of the capture that was read."""
        return InputError(_inside(self.file, capture), self.reason, _CURE)


def _command(operation: str, note: int) -> list[str]:
    return module_command("server.captures.capture_reader", operation, str(note))


class CaptureReaders:
    """Starts and tracks the readers; safe to use from several threads. Its methods block."""

    def __init__(self, home: Home, command: Callable[[str, int], Sequence[str]] = _command) -> None:
        """Start nothing yet; tests pass a `command` of their own, for an operation and a descriptor."""
        self._command = command
        self._environment = without_secrets({**os.environ, **home.environment()})
        self._running: set[ProcessTree] = set()
        self._lock = threading.Lock()
        self._closed = False

    def read(self, operation: str, request: dict[str, Any], patience: float) -> Iterator[dict[str, Any]]:
        """Yield the results of a `server.captures.capture_reader` for a request, each within `patience` seconds.

        Raises:
            ReaderEndedError: it ended before it had finished.
        """
        with tempfile.TemporaryFile() as note, tempfile.TemporaryFile() as errors:
            process = subprocess.Popen(
                self._command(operation, note.fileno()),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=errors,
                pass_fds=(note.fileno(),),
                env=self._environment,
                start_new_session=True,
            )
            tree, late = ProcessTree(process.pid), threading.Event()
            with self._lock:
                self._running.add(tree)
                closed = self._closed
            if closed:
                tree.kill()
            try:
                yield from _answers(process, request, patience, tree, late)
                ended = process.wait()
            finally:
                tree.kill()
                process.wait()
                for pipe in (process.stdin, process.stdout):
                    if pipe is not None:
                        with contextlib.suppress(BrokenPipeError):  # it ended before it read the request
                            pipe.close()
                with self._lock:
                    self._running.discard(tree)
                _log(operation, errors)
            if ended != 0:
                raise _reason(_noted(note), ended, late.is_set(), patience)

    def close(self) -> None:
        """End all readers, including any started later."""
        with self._lock:
            self._closed, running = True, list(self._running)
        for tree in running:
            tree.kill()


def answered(answer: dict[str, Any], capture: Path) -> dict[str, Any]:
    """Return the content of a capture from a reader's result.

    Raises:
        InputError: the capture is rejected, or cannot be read.
        ProblemError: it may not be read.
        OSError: the disk is full, or the like.
    """
    if problem := answer.get("problem"):
        raise ProblemError(problem["status"], problem["code"], problem["detail"], field="capture")
    if refused := answer.get("refused"):
        raise InputError(*refused)
    if reason := answer.get("unreadable"):
        raise InputError(_inside(answer["file"], capture), reason, _CURE)
    if "error" in answer:
        raise OSError(answer["errno"], answer["error"])
    found: dict[str, Any] = answer["found"]
    return found


def _answers(
    process: subprocess.Popen[bytes], request: dict[str, Any], patience: float, tree: ProcessTree, late: threading.Event
) -> Iterator[dict[str, Any]]:
    def end() -> None:
        late.set()
        tree.kill()

    assert process.stdin is not None
    assert process.stdout is not None
    with contextlib.suppress(OSError):  # it has ended: its exit status tells why
        process.stdin.write(json.dumps(request).encode() + b"\n")
        process.stdin.flush()  # left open: a reader whose server is gone exits when it closes
    while True:
        timer = threading.Timer(patience, end)
        timer.start()
        try:
            line = process.stdout.readline(_LONGEST_ANSWER)
        finally:
            timer.cancel()
        if not line.endswith(b"\n"):
            return
        yield json.loads(line)


def _noted(note: IO[bytes]) -> str:
    return os.fsdecode(os.pread(note.fileno(), NOTE_BYTES, 0).rstrip(b"\0"))


def _log(operation: str, errors: IO[bytes]) -> None:
    errors.seek(0, os.SEEK_END)
    errors.seek(max(0, errors.tell() - _LOGGED))
    if told := errors.read().decode(errors="replace").strip():
        log.warning("captures, %s: %s", operation, told)


def _reason(file: str, status: int, late: bool, patience: float) -> ReaderEndedError:
    if late:
        return ReaderEndedError(file, f"takes longer to read than {patience:.0f} s")
    if status == -signal.SIGXCPU:
        return ReaderEndedError(file, "takes more processor time to read than a capture may use")
    told = signal.Signals(-status).name if -status in set(signal.Signals) else f"status {status}"
    return ReaderEndedError(file, f"is damaged or malicious: reading it crashed the reader process ({told})")


def _inside(file: str, capture: Path) -> Path:
    """Return the file, or the capture itself if the file lies outside it."""
    return Path(file) if Path(file).is_relative_to(capture) else capture
