"""Sending a capture to a server, as docs/upload.md has it."""

from __future__ import annotations

import base64
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any
from urllib.parse import urljoin

from hgs_core.base.errors import InputError
from server.cli.capture_files import CaptureFile, upload_key
from server.cli.server_client import LostConnectionError, RefusedError, ServerClient

__all__ = ["SentBytes", "send_capture"]

_PIECE = 8 << 20  # bytes in one request
_SMALL = 1 << 20  # bytes of a file that is sent with its announcement
_AT_ONCE = 4  # files
_MOST_TRIES = 30  # tries of one piece while the server answers other questions: ten minutes
_CHANGES = 3  # times that a file may turn out to be another than was announced
_STREAM = "application/offset+octet-stream"
_TUS = {"Tus-Resumable": "1.0.0"}

SentBytes = Callable[[int, int], None]
"""Called with how many bytes the server has, and of how many; it may raise to stop."""


def send_capture(client: ServerClient, name: str, files: list[CaptureFile], progress: SentBytes) -> str:
    """Send the files that the server lacks, and return the path of the capture there.

    Raises:
        InputError: the server refuses it or cannot be reached for long, or a file changes while it is sent.
    """
    sending = _Sending(client, name, files, progress)
    return sending.present() or sending.run()


class _Sending:
    def __init__(self, client: ServerClient, name: str, files: list[CaptureFile], progress: SentBytes) -> None:
        self._client = client
        self._files = files
        self._total = sum(file.size for file in files)
        self._announced = {
            "name": name[:200],
            "files": len(files),
            "bytes": self._total,
            "key": upload_key(files),
        }
        self._progress = progress
        self._sent: dict[str, int] = {}
        self._sent_total = 0
        self._lock = threading.Lock()
        self._stopped = threading.Event()

    def present(self) -> str | None:
        """Return the path of a capture that was sent before and has the same content, if there is one."""
        hashes: dict[str, str] = {}
        for upload in self._client.request("GET", "/v1/uploads").value["uploads"]:
            same = all(upload[name] == self._announced[name] for name in ("name", "files", "bytes"))
            if not same or upload["state"] != "finished":
                continue
            there = self._client.request("GET", f"/v1/uploads/{upload['id']}/files").value["files"]
            if {file["path"]: file["size"] for file in there} != {file.path: file.size for file in self._files}:
                continue
            hashes = hashes or {file.path: file.sha256() for file in self._files}
            if {file["path"]: file["sha256"] for file in there} == hashes:
                return str(upload["capture"])
        return None

    def run(self) -> str:
        begun = self._client.request("POST", "/v1/uploads", json_body=self._announced)
        address = f"/v1/uploads/{begun.value['id']}"
        known: dict[str, Any] = {}
        if begun.status == 200:
            listed = self._client.request("GET", f"{address}/files").value["files"]
            known = {file["path"]: file for file in listed}
            for file in listed:
                self._note(file["path"], file["offset"])
        pool = ThreadPoolExecutor(_AT_ONCE)
        try:  # a stop may come while the first tasks run and others are yet to be submitted
            tasks = [pool.submit(self._send, address, file, known.get(file.path)) for file in self._files]
            for task in tasks:
                task.result()
        except BaseException:
            self._stopped.set()
            self._client.stop()
            raise
        finally:
            pool.shutdown(cancel_futures=True)
        return str(self._client.request("POST", f"{address}/finish").value["capture"])

    def _send(self, address: str, file: CaptureFile, known: dict[str, Any] | None) -> None:
        for attempt in range(_CHANGES):
            sha256 = file.sha256()
            if known is not None and known["verified"] and known["sha256"] == sha256:
                return
            try:
                self._send_content(address, file, sha256, known is None and attempt == 0)
                return
            except RefusedError as error:
                if error.code == "upload-finished":  # another client sent the same
                    return
                if error.code != "checksum-mismatch":
                    raise
        raise InputError(file.file, "changes while it is sent", "wait until it is complete, and run the command again")

    def _send_at_once(self, address: str, file: CaptureFile, headers: dict[str, str]) -> bool:
        """Announce a small file and send it with the same request; return whether that went through."""
        body = file.file.read_bytes()
        if len(body) != file.size or not body:
            return False
        try:
            self._client.once("POST", f"{address}/files", headers=headers | {"Content-Type": _STREAM}, body=body)
        except LostConnectionError:
            return False
        except RefusedError as error:
            if error.code == "offset-mismatch":  # another client has sent it, or is at it
                return False
            raise
        self._note(file.path, file.size)
        return True

    def _send_content(self, address: str, file: CaptureFile, sha256: str, fresh: bool) -> None:
        told = ",".join(f"{name} {_base64(value)}" for name, value in (("path", file.path), ("sha256", sha256)))
        headers = _TUS | {"Upload-Length": str(file.size), "Upload-Metadata": told}
        if file.size <= _SMALL and fresh and self._send_at_once(address, file, headers):
            return
        made = self._client.request("POST", f"{address}/files", headers=headers)
        location = urljoin(f"{address}/files", made.headers["location"])
        offset, tries = int(made.headers["upload-offset"]), 0
        with file.file.open("rb") as content:
            while offset < file.size and not self._stopped.is_set():
                content.seek(offset)
                piece = content.read(min(_PIECE, file.size - offset))
                if not piece:
                    raise InputError(file.file, "has become shorter while it is sent", "run the command again")
                headers = _TUS | {"Upload-Offset": str(offset), "Content-Type": _STREAM}
                try:
                    answer = self._client.once("PATCH", location, headers=headers, body=piece)
                    offset, tries = int(answer.headers["upload-offset"]), 0
                except (LostConnectionError, RefusedError) as error:
                    if isinstance(error, RefusedError) and error.code != "offset-mismatch":
                        raise
                    if tries == _MOST_TRIES:
                        raise InputError(
                            file.file, f"does not get through ({error})", "run the command again"
                        ) from error
                    self._client.wait(tries, error)
                    tries += 1
                    offset = self._received(location, file.size)
                self._note(file.path, offset)

    def _received(self, location: str, size: int) -> int:
        """Return the bytes of a file that the server has; all of them where the upload is complete since."""
        try:
            return int(self._client.request("HEAD", location).headers["upload-offset"])
        except RefusedError as error:
            if error.status != 409:  # the answer to HEAD has no body, and so no code
                raise
            return size

    def _note(self, path: str, offset: int) -> None:
        with self._lock:
            self._sent_total += offset - self._sent.get(path, 0)
            self._sent[path] = offset
            self._progress(self._sent_total, self._total)


def _base64(text: str) -> str:
    return base64.b64encode(text.encode()).decode()
