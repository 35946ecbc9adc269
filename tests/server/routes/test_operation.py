from __future__ import annotations

import pytest

from jobs.records.job import Job, JobState
from tests.server.conftest import Server


def test_a_ready_server_tells_what_it_stands_on(server: Server) -> None:
    server.jobs.jobs["a"] = Job("a", "", "", {}, JobState.RUNNING)
    answer = server.get("/readyz")
    assert answer.status_code == 200
    found = answer.json()
    assert (found["database"], found["store"], found["workers"], found["stopping"]) == ("ok", "ok", 0, False)
    assert found["jobs"]["running"] == 1


@pytest.mark.parametrize("away", ["database", "store"])
def test_a_server_whose_database_or_store_is_away_is_alive_and_not_ready(server: Server, away: str) -> None:
    if away == "database":
        server.jobs.refuse = OSError("no database")
    else:
        server.artifacts.manifests = None  # type: ignore[assignment]
    answer = server.get("/readyz")
    assert (answer.status_code, answer.json()[away]) == (503, "does not answer")
    assert server.get("/healthz").json() == {"status": "ok"}


def test_metrics_tell_the_queue_and_the_requests(server: Server) -> None:
    server.get("/v1/health")
    server.jobs.jobs["a"] = Job("a", "", "", {}, JobState.QUEUED)
    answer = server.get("/metrics")
    assert answer.headers["Content-Type"].startswith("text/plain; version=0.0.4")
    assert 'hgs_jobs{state="queued"} 1.0' in answer.text
    assert "hgs_workers 0.0" in answer.text
    assert 'route="/v1/health",status="200"} 1.0' in answer.text


def test_metrics_are_told_without_the_database(server: Server) -> None:
    server.jobs.refuse = OSError("no database")
    assert server.get("/metrics").status_code == 200


def test_the_description_names_every_route_of_the_api(server: Server) -> None:
    paths = server.get("/openapi.json").json()["paths"]
    assert {"/v1/jobs", "/v1/scenes/{scene_id}", "/v1/chunks/{chunk_id}", "/v1/session", "/healthz"} <= set(paths)
