"""`POST /v1/scenes/{id}/edits`."""

from __future__ import annotations

from typing import Any

import pytest

from server.routes import edits

BODY = b'{"format": "hgs-splats", whatever is wrong is the job\'s to say'
JSON = {"Content-Type": "application/json"}


def test_an_edit_becomes_a_job_and_its_list_is_passed_on_unread(server: Any) -> None:
    answer = server.request("POST", "/v1/scenes/studio/edits?title=Clean", content=BODY, headers=JSON)
    assert answer.status_code == 201
    job = answer.json()
    assert (job["title"], job["state"], job["scene"]) == ("Clean", "queued", None)
    assert answer.headers["Location"] == f"../../jobs/{job['id']}"
    (asked,) = server.jobs.edits
    assert (asked.scene, asked.document, asked.title) == ("studio", BODY, "Clean")


def test_an_unknown_scene_is_404(server: Any) -> None:
    answer = server.request("POST", "/v1/scenes/other/edits", content=BODY, headers=JSON)
    assert (answer.status_code, answer.json()["code"]) == (404, "scene-not-found")


def test_a_title_of_two_lines_is_refused(server: Any) -> None:
    answer = server.request("POST", "/v1/scenes/studio/edits", params={"title": "a\nb"}, content=BODY, headers=JSON)
    assert (answer.status_code, answer.json()["field"]) == (422, "title")
    assert server.jobs.edits == []


def test_a_list_that_is_too_large_is_413(server: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(edits, "MAX_EDIT_BYTES", 50)
    answer = server.request("POST", "/v1/scenes/studio/edits", content=b" " * 51, headers=JSON)
    assert (answer.status_code, answer.json()["code"]) == (413, "body-too-large")


@pytest.mark.parametrize(
    ("headers", "status"), [({"Content-Type": "text/plain"}, 415), (JSON | {"Origin": "https://evil.example"}, 403)]
)
def test_a_form_of_another_site_starts_nothing(server: Any, headers: dict[str, str], status: int) -> None:
    answer = server.request("POST", "/v1/scenes/studio/edits", content=BODY, headers=headers)
    assert answer.status_code == status
    assert server.jobs.edits == []


def test_the_idempotency_key_is_part_of_the_request(server: Any) -> None:
    headers = JSON | {"Idempotency-Key": "k-1"}
    server.request("POST", "/v1/scenes/studio/edits", content=BODY, headers=headers)
    assert [asked.key for asked in server.jobs.edits] == ["k-1"]


def test_a_malformed_key_starts_nothing(server: Any) -> None:
    answer = server.request("POST", "/v1/scenes/studio/edits", content=BODY, headers=JSON | {"Idempotency-Key": "a b"})
    assert (answer.status_code, answer.json()["field"]) == (422, "Idempotency-Key")
    assert server.jobs.edits == []
