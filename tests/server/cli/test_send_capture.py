"""Sending to the routes of a server, without a line between; over one, see test_submit_to_server.py."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from server.cli import send_capture as module
from server.cli import server_client
from server.cli.capture_files import CaptureFile, capture_files
from server.cli.send_capture import send_capture
from server.cli.server_client import Answer, LostConnectionError, RefusedError, ServerClient


class Direct(ServerClient):
    """A client that calls the application; `before` may stand in the way of a request."""

    def __init__(self, server: Any) -> None:
        super().__init__("http://localhost")
        self.server = server
        self.requests: list[str] = []
        self.before: Callable[[str, str], None] = lambda method, path: None

    def once(self, method: str, path: str, **arguments: Any) -> Answer:
        self.requests.append(f"{method} {path.split('/')[-1]}")
        self.before(method, path)
        if (value := arguments.get("json_body")) is not None:
            sent = {"headers": {"Content-Type": "application/json"}, "content": json.dumps(value).encode()}
        else:
            sent = {"headers": arguments.get("headers"), "content": arguments.get("body", b"")}
        response = self.server.request(method, path, **sent)
        is_json = "json" in response.headers.get("content-type", "")
        answer = Answer(
            response.status_code, response.headers, response.json() if is_json and response.content else None
        )
        if answer.status >= 400:
            raise RefusedError("server", answer)
        return answer


@pytest.fixture
def client(server: Any, monkeypatch: pytest.MonkeyPatch) -> Iterator[Direct]:
    monkeypatch.setattr(server_client, "_LONGEST_WAIT", 0.0)
    monkeypatch.setattr(module, "_PIECE", 1000)
    monkeypatch.setattr(module, "_SMALL", 500)
    monkeypatch.setattr(module, "_AT_ONCE", 1)
    yield Direct(server)
    server.app.state.service.uploads.close()


@pytest.fixture
def files(tmp_path: Path) -> list[CaptureFile]:
    folder = tmp_path / "studio"
    (folder / "sparse").mkdir(parents=True)
    for name, size in {"cam00.mp4": 2500, "sparse/cameras.txt": 100, "empty": 0}.items():
        (folder / name).write_bytes(os.urandom(size))
    return capture_files(folder)


def test_the_files_are_there_under_their_names(client: Direct, files: list[CaptureFile]) -> None:
    told: list[tuple[int, int]] = []
    capture = Path(send_capture(client, "studio", files, lambda done, total: told.append((done, total))))
    assert {str(p.relative_to(capture)): p.read_bytes() for p in capture.rglob("*") if p.is_file()} == {
        file.path: file.file.read_bytes() for file in files
    }
    assert told[-1] == (2600, 2600)
    assert client.requests.count("PATCH 0") == 3
    assert client.requests.count("POST files") == 3  # the small one came with its announcement


def test_what_is_there_is_not_sent_again(client: Direct, files: list[CaptureFile]) -> None:
    class StopError(Exception):
        pass

    def stop(done: int, total: int) -> None:
        if done >= 2000:
            raise StopError

    with pytest.raises(StopError):
        send_capture(client, "studio", files, stop)
    client.requests.clear()
    capture = send_capture(client, "studio", files, lambda done, total: None)
    assert client.requests.count("PATCH 0") == 1
    client.requests.clear()
    assert send_capture(client, "studio", files, lambda done, total: None) == capture
    assert not any(request.startswith(("PATCH", "POST")) for request in client.requests)


def test_a_lost_answer_is_asked_after(client: Direct, files: list[CaptureFile]) -> None:
    lost = iter([LostConnectionError("cut"), LostConnectionError("cut")])

    def lose(method: str, path: str) -> None:
        if method == "PATCH" and (error := next(lost, None)):
            raise error

    client.before = lose
    send_capture(client, "studio", files, lambda done, total: None)
    assert client.requests.count("HEAD 0") == 2


def test_two_clients_that_send_the_same_both_come_to_its_end(
    server: Any, client: Direct, files: list[CaptureFile]
) -> None:
    with ThreadPoolExecutor(2) as pool:
        sent = [pool.submit(send_capture, Direct(server), "studio", files, lambda done, total: None) for _ in range(2)]
        first, second = (Path(one.result(60)) for one in sent)
    assert first == second
    assert (first / "cam00.mp4").read_bytes() == files[0].file.read_bytes()


def test_a_small_file_that_another_client_sends_meanwhile_is_asked_after(
    client: Direct, files: list[CaptureFile]
) -> None:
    class BehindAnother(Direct):
        def once(self, method: str, path: str, **arguments: Any) -> Answer:
            answer = super().once(method, path, **arguments)
            if method == "POST" and path.endswith("/files") and arguments.get("body"):
                told = {"code": "offset-mismatch", "detail": "has 100 bytes, not 0"}
                raise RefusedError("server", Answer(409, answer.headers, told))
            return answer

    sent = Path(send_capture(BehindAnother(client.server), "studio", files, lambda done, total: None))
    assert len((sent / "sparse" / "cameras.txt").read_bytes()) == 100


def test_a_file_whose_upload_another_client_finishes_meanwhile_is_there(
    client: Direct, files: list[CaptureFile]
) -> None:
    other = Direct(client.server)

    def overtake(method: str, path: str) -> None:
        if method == "PATCH":
            client.before = lambda method, path: None
            send_capture(other, "studio", files, lambda done, total: None)
            raise LostConnectionError("cut")

    client.before = overtake
    sent = Path(send_capture(client, "studio", files, lambda done, total: None))
    assert client.requests.count("HEAD 0") == 1  # it was asked when all was over
    assert (sent / "cam00.mp4").read_bytes() == files[0].file.read_bytes()


def test_a_piece_that_never_gets_through_is_given_up_on(client: Direct, files: list[CaptureFile]) -> None:
    def lose(method: str, path: str) -> None:
        if method == "PATCH":
            raise LostConnectionError("cut")

    client.before = lose
    with pytest.raises(InputError, match=r"does not get through \(cut\); run the command again"):
        send_capture(client, "studio", files, lambda done, total: None)


def test_a_file_that_changes_all_the_time_is_given_up_on(client: Direct, files: list[CaptureFile]) -> None:
    def change(method: str, path: str) -> None:
        if method == "POST" and path.endswith("/files"):  # between the hash and the bytes
            files[0].file.write_bytes(os.urandom(2500))

    client.before = change
    with pytest.raises(InputError, match="changes while it is sent; wait"):
        send_capture(client, "studio", files, lambda done, total: None)
    client.before = lambda method, path: None
    assert send_capture(client, "studio", files, lambda done, total: None)
