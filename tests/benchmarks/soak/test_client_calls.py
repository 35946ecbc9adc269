from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer

import pytest

from benchmarks.soak.client_calls import Answer, Board, ClientCalls
from benchmarks.soak.request_history import Act, Event


class Echo(BaseHTTPRequestHandler):
    def do_POST(self) -> None:
        body = self.rfile.read(int(self.headers["Content-Length"]))
        told = json.dumps({"body": json.loads(body), "key": self.headers["Authorization"]}).encode()
        self.send_response(201)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(told)))
        self.end_headers()
        self.wfile.write(told)

    def log_message(self, *words: object) -> None:
        pass


@pytest.fixture
def address() -> Iterator[str]:
    server = HTTPServer(("127.0.0.1", 0), Echo)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"127.0.0.1:{server.server_port}"
    server.shutdown()
    thread.join()
    server.server_close()


def test_a_request_carries_the_key_and_brings_the_answer(board: Board, address: str) -> None:
    board.address = address
    answer = ClientCalls("a", board, 1).ask("POST", "/v1/jobs", {"capture": "room"})
    assert (answer.status, answer.headers["content-type"]) == (201, "application/json")
    assert answer.body == {"body": {"capture": "room"}, "key": "Bearer hgs_key"}


def test_no_answer_is_status_0(board: Board) -> None:
    assert ClientCalls("a", board, 1).ask("GET", "/v1/jobs") == Answer(0)


def test_answers_are_noted_with_their_facts_and_refusals_with_their_code(
    board: Board, noted: Callable[[], list[Event]]
) -> None:
    calls = ClientCalls("a", board, 1)
    calls.note(Act.CANCEL, "job", lambda: Answer(202, {"id": "job"}), lambda answer: {"id": answer.body["id"]})
    calls.note(Act.CANCEL, "job", lambda: Answer(409, {"code": "job-finished"}), lambda answer: {"id": 1})
    calls.note(Act.CANCEL, "job", lambda: Answer(0))
    assert [(event.status, event.answer) for event in noted()] == [
        (202, {"id": "job"}),
        (409, {"code": "job-finished"}),
        (0, {}),
    ]


def test_dice_are_the_client_s_own(board: Board) -> None:
    def thrown(name: str, seed: int) -> list[float]:
        dice = ClientCalls(name, board, seed).dice
        return [dice.random() for _ in range(3)]

    assert thrown("a", 1) == thrown("a", 1)
    assert thrown("a", 1) != thrown("b", 1)
    assert thrown("a", 1) != thrown("a", 2)
