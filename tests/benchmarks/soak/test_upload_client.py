from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.soak.client_calls import Answer, Board
from benchmarks.soak.request_history import Act, Event
from benchmarks.soak.upload_client import CaptureFiles, upload_client

Scripted = Callable[[Callable[[str, str, Any], Answer]], Any]


def test_a_folder_is_read_with_its_digests(tmp_path: Path) -> None:
    (tmp_path / "ims").mkdir()
    (tmp_path / "ims" / "0.jpg").write_bytes(b"x")
    capture = CaptureFiles.of(tmp_path)
    assert capture.files == {"ims/0.jpg": b"x"}
    assert capture.digests["ims/0.jpg"].startswith("2d711642")


def test_a_capture_arrives_in_spite_of_lost_answers(
    board: Board, scripted: Scripted, noted: Callable[[], list[Event]]
) -> None:
    arrived = bytearray()
    lost = iter([True, False, True])

    def answer(method: str, path: str, body: Any) -> Answer:
        if path == "/v1/uploads":
            return Answer(201, {"id": "u"})
        if path.endswith("/files"):
            return Answer(201, headers={"location": "files/0", "upload-offset": str(len(arrived))})
        if path.endswith("/finish"):
            board.stop.set()
            return Answer(200, {"capture": "/captures/room"})
        if method == "PATCH":
            arrived.extend(body)
            if next(lost, False):
                return Answer(0)
        return Answer(204, headers={"upload-offset": str(len(arrived))})

    upload_client(scripted(answer), CaptureFiles({"a.jpg": bytes(range(200))}))
    assert bytes(arrived) == bytes(range(200))
    assert board.captures == ["/captures/room"]
    (finished,) = [event for event in noted() if event.act is Act.FINISH_UPLOAD]
    assert finished.acknowledged
    assert set(finished.request["digests"]) == {"a.jpg"}
