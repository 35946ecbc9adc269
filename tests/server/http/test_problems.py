from __future__ import annotations

import asyncio
import errno
import json
import logging
from typing import Any

import httpx
import pytest
from fastapi import FastAPI
from obstore.exceptions import GenericError
from sqlalchemy.exc import OperationalError
from starlette.requests import ClientDisconnect

from hgs_core.base.errors import InputError
from server.http.problems import ProblemError, install_problem_handlers, problem_document


def answer_to(error: Exception | None, path: str = "/fault", method: str = "GET") -> httpx.Response:
    """Return the answer to a client when a route at /fault raises `error`."""
    app = FastAPI(openapi_url=None)
    install_problem_handlers(app)

    @app.get("/fault")
    def fault(number: int = 0) -> None:
        if error is not None:
            raise error

    async def ask() -> httpx.Response:
        transport = httpx.ASGITransport(app, raise_app_exceptions=False)
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:
            return await client.request(method, path)

    return asyncio.run(ask())


def test_a_problem_is_answered_as_rfc_9457_lays_it_out() -> None:
    answer = answer_to(ProblemError(409, "job-finished", "job 3 is done", field="job", headers={"Retry-After": "5"}))
    assert (answer.status_code, answer.headers["content-type"]) == (409, "application/problem+json")
    assert answer.headers["retry-after"] == "5"
    assert answer.json() == {
        "type": "about:blank",
        "title": "Conflict",
        "status": 409,
        "detail": "job 3 is done",
        "instance": "/fault",
        "code": "job-finished",
        "field": "job",
    }


def test_a_problem_of_no_field_names_none() -> None:
    assert "field" not in json.loads(problem_document(ProblemError(404, "not-found", "no"), "/"))


def told(answer: httpx.Response, status: int, code: str) -> str:
    """Check the answer, and return its words."""
    body: dict[str, Any] = answer.json()
    assert (answer.status_code, body["status"], body["code"]) == (status, status, code)
    detail: str = body["detail"]
    return detail


def test_bad_input_is_422_with_its_line() -> None:
    detail = told(answer_to(InputError("cam03.mp4", "59 frames", "record it again")), 422, "body-invalid")
    assert detail == "cam03.mp4: 59 frames; record it again"


def test_a_parameter_that_does_not_fit_is_422_and_named() -> None:
    answer = answer_to(None, "/fault?number=many")
    assert told(answer, 422, "body-invalid").startswith("number: ")
    assert answer.json()["field"] == "number"


def test_unknown_addresses_are_404() -> None:
    assert told(answer_to(None, "/v1/nonsense"), 404, "not-found") == "/v1/nonsense: nothing here"


def test_wrong_methods_are_405_with_those_that_are_right() -> None:
    answer = answer_to(None, method="DELETE")
    assert "DELETE" in told(answer, 405, "method-not-allowed")
    assert answer.headers["allow"] == "GET"


def test_a_database_that_does_not_answer_is_503_and_logged(caplog: pytest.LogCaptureFixture) -> None:
    answer = answer_to(OperationalError("SELECT", {}, Exception("connection refused")))
    assert "SELECT" not in told(answer, 503, "queue-unavailable")
    assert answer.headers["retry-after"] == "5"
    assert "connection refused" in caplog.text


def test_a_store_that_does_not_answer_is_503_and_logged_in_one_line(caplog: pytest.LogCaptureFixture) -> None:
    answer = answer_to(GenericError("Generic S3 error: connection refused\n\nDebug source:\nGeneric {"))
    assert "S3" not in told(answer, 503, "store-unavailable")
    assert answer.headers["retry-after"] == "5"
    assert "connection refused" in caplog.text
    assert "Debug source" not in caplog.text


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EDQUOT])
def test_a_full_disk_is_507_and_its_folders_are_not_told(code: int, caplog: pytest.LogCaptureFixture) -> None:
    answer = answer_to(OSError(code, "No space left on device", "/home/runs/studio-1/run.json"))
    detail = told(answer, 507, "storage-full")
    assert "disk is full" in detail
    assert "/home" not in detail
    assert answer.headers["retry-after"] == "30"
    assert "/home/runs/studio-1/run.json" in caplog.text


@pytest.mark.parametrize("fault", [RuntimeError("secret"), OSError(errno.EACCES, "secret")])
def test_faults_are_500_and_tell_nothing(fault: Exception) -> None:
    assert "secret" not in told(answer_to(fault), 500, "internal")


def test_a_client_that_has_left_is_no_fault(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.ERROR):
        assert answer_to(ClientDisconnect()).status_code == 400
    assert caplog.records == []


@pytest.mark.parametrize("text", ["\ud800", "\0", "a\nb", "€", "\U0001f600", '"\\'])
def test_problem_document_can_always_be_written(text: str) -> None:
    document = json.loads(problem_document(ProblemError(422, "body-invalid", text, field=text), f"/{text}"))
    assert document["status"] == 422
    assert "\n" not in document["detail"]


def test_an_answer_repeats_no_more_than_the_beginning_of_a_long_path() -> None:
    answer = answer_to(None, "/v1/" + "a" * 60_000)
    assert told(answer, 404, "not-found").endswith("…: nothing here")
    assert len(answer.content) < 2000
