from __future__ import annotations

from typing import Any

import pytest
from starlette.requests import HTTPConnection

from server.http.problems import ProblemError
from server.service import Service


@pytest.fixture
def service(server: Any) -> Service:
    built: Service = server.app.state.service
    return built


@pytest.mark.parametrize("job_id", ["never-was", "../etc", "\x00", "a" * 10_000])
def test_a_job_that_does_not_exist_is_not_found(service: Service, job_id: str) -> None:
    with pytest.raises(ProblemError) as caught:
        service.known_job(job_id)
    assert caught.value.status == 404


def test_requests_without_a_key_count_as_one(service: Service) -> None:
    assert service.key_of(HTTPConnection({"type": "http", "headers": []})) == ""
