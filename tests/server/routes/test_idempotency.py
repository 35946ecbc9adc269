"""The header `Idempotency-Key`."""

from __future__ import annotations

from typing import Any

import pytest

from jobs.queue.client import KeyReusedError

KEY = {"Idempotency-Key": "k-1", "Content-Type": "application/json"}


@pytest.mark.parametrize(
    ("method", "path", "body"),
    [("submit", "/v1/jobs", b'{"capture": "studio"}'), ("edit", "/v1/scenes/studio/edits", b"a list")],
)
def test_a_key_of_another_request_is_refused(
    server: Any, monkeypatch: pytest.MonkeyPatch, method: str, path: str, body: bytes
) -> None:
    def refuse(request: Any) -> str:
        raise KeyReusedError(f"the key {request.key!a} was given before")

    monkeypatch.setattr(server.jobs, method, refuse)
    answer = server.request("POST", path, content=body, headers=KEY)
    problem = answer.json()
    assert (answer.status_code, problem["code"], problem["field"]) == (422, "idempotency-key-reused", "Idempotency-Key")
