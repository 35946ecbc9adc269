from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.soak.client_calls import Answer, Board
from benchmarks.soak.job_client import JobActions, job_client
from benchmarks.soak.request_history import Act, Event

Scripted = Callable[[Callable[[str, str, Any], Answer]], Any]
JOB = {"id": "a", "state": "succeeded", "stage": "publish", "attempt": 1, "waiting": None, "error": None}


def test_a_job_is_submitted_until_it_is_acknowledged(
    board: Board, scripted: Scripted, noted: Callable[[], list[Event]]
) -> None:
    board.captures.append("/room")
    answers = iter([Answer(0), Answer(202, {"id": "s"}), Answer(200, {"id": "a"})])
    asked: list[str] = []
    assert not board.submitted.is_set()

    def answer(method: str, path: str, body: Any) -> Answer:
        asked.append(path)
        return next(answers, Answer(201, {"id": "a"}))

    assert JobActions(scripted(answer)).submit() == "a"
    assert board.submitted.is_set()
    assert asked[:3] == ["/v1/jobs", "/v1/jobs", "/v1/submissions/s"]
    assert [(event.target, event.status) for event in noted()][:2] == [("client-1", 0), ("client-1", 200)]


def test_a_refused_change_is_not_repeated(scripted: Scripted, noted: Callable[[], list[Event]]) -> None:
    answers = iter([Answer(503, {"code": "busy"}), Answer(401, {"code": "key-needed"}), Answer(409, {"code": "no"})])
    actions = JobActions(scripted(lambda method, path, body: next(answers)))
    assert actions.change(Act.CANCEL, "a", "POST", "/v1/jobs/a/cancel").status == 409
    assert [event.status for event in noted()] == [503, 401, 409]


def test_lives_of_all_kinds_are_led(
    board: Board, scripted: Scripted, noted: Callable[[], list[Event]], tmp_path: Path
) -> None:
    board.captures.append("/room")

    def answer(method: str, path: str, body: Any) -> Answer:
        if {event.act for event in noted()} >= {Act.CANCEL, Act.RETRY, Act.RENAME, Act.DELETE_SCENE, Act.DELETE_JOB}:
            board.stop.set()
        return Answer(201 if path == "/v1/jobs" else 200, JOB, b"{}")

    calls = scripted(answer)
    calls.dice.seed(1)
    job_client(calls, tmp_path)
    assert {Act.SUBMIT, Act.SEE, Act.READ_SCENE} <= {event.act for event in noted()}
    assert board.scenes
