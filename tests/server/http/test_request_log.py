from __future__ import annotations

import io
import json
import logging
from collections.abc import Iterator
from typing import Any

import pytest

from server.http.request_log import REQUEST_ID, configure_access_log
from tests.server.conftest import Server


@pytest.fixture
def lines() -> Iterator[Any]:
    log = logging.getLogger("hgs.access")
    before = log.level, log.propagate
    written = io.StringIO()
    configure_access_log(written)
    yield lambda: [json.loads(line) for line in written.getvalue().splitlines()]
    log.handlers.clear()
    log.setLevel(before[0])
    log.propagate = before[1]


def test_every_request_is_a_line_without_its_query(server: Server, lines: Any) -> None:
    answer = server.get("/v1/scenes/nowhere?link=secret")
    [line] = lines()
    assert {name: line[name] for name in ("method", "path", "status", "key")} == {
        "method": "GET",
        "path": "/v1/scenes/nowhere",
        "status": 404,
        "key": None,
    }
    assert line["bytes"] == len(answer.content)
    assert line["id"] == answer.headers[REQUEST_ID]
    assert "secret" not in json.dumps(line)


def test_deletions_alone_are_lines_where_nothing_more_is_asked_for(server: Server, lines: Any) -> None:
    configure_access_log(io.StringIO(), deletions_only=True)
    server.get("/v1/scenes/nowhere")
    server.request("DELETE", "/v1/scenes/nowhere")
    [line] = lines()
    assert (line["method"], line["path"]) == ("DELETE", "/v1/scenes/nowhere")


def test_a_proxys_id_is_kept_and_another_text_is_not(server: Server) -> None:
    assert server.get("/v1/health", X_Request_Id="abc-1.2").headers[REQUEST_ID] == "abc-1.2"
    for odd in ("", "a b", "x" * 65):
        assert server.get("/v1/health", X_Request_Id=odd).headers[REQUEST_ID] != odd


def test_without_it_nothing_is_written(server: Server, capsys: pytest.CaptureFixture[str]) -> None:
    server.get("/v1/health")
    assert capsys.readouterr().err == ""


def test_requests_are_counted_by_route_not_by_path(server: Server) -> None:
    for name in ("a", "b"):
        server.get(f"/v1/scenes/{name}")
    text = server.get("/metrics").text
    assert 'hgs_requests_total{method="GET",route="/v1/scenes/{scene_id}",status="404"} 2.0' in text
