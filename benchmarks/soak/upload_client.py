"""A client that sends captures in small pieces, goes on after every fault, and deletes some of them."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from benchmarks.soak.client_calls import Answer, ClientCalls
from benchmarks.soak.request_history import Act

__all__ = ["CaptureFiles", "upload_client"]

PAUSE = 20.0  # seconds between two uploads
TUS = {"Tus-Resumable": "1.0.0"}


@dataclass(frozen=True)
class CaptureFiles:
    """The files of a capture to send, by their paths in it."""

    files: Mapping[str, bytes]

    @classmethod
    def of(cls, folder: Path) -> CaptureFiles:
        """Read a folder."""
        paths = sorted(path for path in folder.rglob("*") if path.is_file())
        return cls({path.relative_to(folder).as_posix(): path.read_bytes() for path in paths})

    @property
    def digests(self) -> dict[str, str]:
        """The SHA-256 of every file."""
        return {path: hashlib.sha256(data).hexdigest() for path, data in self.files.items()}


def upload_client(calls: ClientCalls, capture: CaptureFiles) -> None:
    """Send captures until the soak is over; every third one is deleted again, and no job hears of it."""
    number = 0
    while not calls.over:
        number += 1
        name = f"{calls.name}-{number}"
        while not (found := _sent(calls, name, capture)):
            if not calls.rest(1.0):
                return
        address, folder = found
        if number % 3 == 2:
            calls.note(Act.DELETE_UPLOAD, folder, lambda address=address: calls.ask("DELETE", address))  # type: ignore[misc]
        else:
            calls.board.captures.append(folder)
        calls.rest(calls.dice.uniform(0.5, 1.5) * PAUSE)


def _sent(calls: ClientCalls, name: str, capture: CaptureFiles) -> tuple[str, str] | None:
    """Send a capture, and return the address of its upload and its path; None where it has to be begun again."""
    size = sum(map(len, capture.files.values()))
    body = {"name": name, "files": len(capture.files), "bytes": size, "key": name}
    begun = calls.note(
        Act.BEGIN_UPLOAD, name, lambda: calls.ask("POST", "/v1/uploads", body), lambda answer: {"id": answer.body["id"]}
    )
    if not begun.acknowledged:
        return None
    address = f"/v1/uploads/{begun.answer['id']}"
    for path, data in capture.files.items():
        if not _sent_file(calls, address, path, data):
            return None
    finished = calls.note(
        Act.FINISH_UPLOAD,
        name,
        lambda: calls.ask("POST", f"{address}/finish"),
        lambda answer: {"capture": answer.body["capture"]},
        {"digests": capture.digests},
    )
    return (address, str(finished.answer["capture"])) if finished.acknowledged else None


def _sent_file(calls: ClientCalls, upload: str, path: str, data: bytes) -> bool:
    digest = hashlib.sha256(data).hexdigest()
    metadata = f"path {_base64(path)},sha256 {_base64(digest)}"
    announced = calls.ask(
        "POST", f"{upload}/files", b"", TUS | {"Upload-Length": str(len(data)), "Upload-Metadata": metadata}
    )
    if not announced.ok:
        return False
    file = f"{upload}/{announced.headers['location']}"
    offset = int(announced.headers["upload-offset"])
    while offset < len(data):
        piece = data[offset : offset + calls.dice.randrange(1, len(data) + 1)]
        headers = TUS | {"Upload-Offset": str(offset), "Content-Type": "application/offset+octet-stream"}
        sent = calls.note(Act.SEND, file, lambda: calls.ask("PATCH", file, piece, headers), _offset)  # noqa: B023
        if not sent.acknowledged or calls.dice.random() < 0.1:
            asked = calls.note(Act.ASK_OFFSET, file, lambda: calls.ask("HEAD", file, headers=TUS), _offset)
            if not asked.acknowledged:
                return False
            offset = asked.answer["offset"]
        else:
            offset = sent.answer["offset"]
    return True


def _base64(text: str) -> str:
    return base64.b64encode(text.encode()).decode()


def _offset(answer: Answer) -> dict[str, int]:
    return {"offset": int(answer.headers["upload-offset"])}
