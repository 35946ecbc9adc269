"""What `docker compose up` starts, as processes, at the same moment, on an empty Postgres."""

from __future__ import annotations

import json
import socket
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa
from composition import DATABASE, Composition
from postgres_server import PostgresServer

Poll = Callable[[Callable[[], bool], str], None]


@pytest.fixture
def port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        free: int = probe.getsockname()[1]
        return free


@pytest.fixture
def composition(tcp_server: PostgresServer, tmp_path: Path, port: int) -> Iterator[Composition]:
    composition = Composition(tmp_path, ("127.0.0.1", tcp_server.port), port, {})
    composition.captures.mkdir()
    user = composition.services[DATABASE]["environment"]
    assert user["POSTGRES_USER"] == "hgs"  # that of the test's server, which believes every password
    tcp_server.new_database(user["POSTGRES_DB"])
    yield composition
    composition.stop()
    tcp_server.execute("postgres", f"DROP DATABASE {user['POSTGRES_DB']} WITH (FORCE)")


def ask(port: int, path: str, body: dict[str, Any] | None = None) -> Any:
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(
        f"http://127.0.0.1:{port}{path}", data, headers={"Content-Type": "application/json"}
    )
    with urllib.request.urlopen(request) as answer:
        return json.load(answer)


def test_everything_that_the_file_starts_is_started_here(composition: Composition) -> None:
    assert set(composition.services) == {"api", "worker", DATABASE}
    for service in ("api", "worker"):
        assert composition.services[service]["depends_on"] == {DATABASE: {"condition": "service_healthy"}}
        assert composition.services[service]["restart"] == "unless-stopped"
        environment = composition.environment(service)
        assert environment["HGS_HOME"].startswith(str(composition.captures.parent))
        assert environment["HGS_CAPTURES"] == str(composition.captures)
        url = sa.make_url(composition.services[service]["environment"]["HGS_DATABASE_URL"])
        database = composition.services[DATABASE]["environment"]
        assert (url.username, url.password, url.database) == (
            database["POSTGRES_USER"], database["POSTGRES_PASSWORD"], database["POSTGRES_DB"],
        )  # fmt: skip
    assert composition.services["api"]["environment"] == composition.services["worker"]["environment"]


def test_it_becomes_healthy_and_runs_a_job(composition: Composition, port: int, wait_until: Poll) -> None:
    pipeline = {"HGS_PIPELINE": "counting_pipeline"}  # the only thing that is not as in the file
    processes = [composition.start(service, **pipeline) for service in ("api", "worker", "worker")]
    (composition.captures / "take").mkdir()
    (composition.captures / "take" / "behaviour").write_text("count")

    def healthy() -> bool:
        assert all(process.poll() is None for process in processes), composition.log()
        return composition.healthy("api")

    wait_until(healthy, "the health check")
    job = ask(port, "/v1/jobs", {"capture": "take", "config": {"iterations": 5}})

    def finished() -> bool:
        nonlocal job
        job = ask(port, f"/v1/jobs/{job['id']}")
        return job["state"] not in ("queued", "running")

    wait_until(finished, "the end of the job")
    assert (job["state"], job["error"]) == ("succeeded", None)
    assert [scene["id"] for scene in ask(port, "/v1/scenes")["scenes"]] == [job["id"]]
    assert all(process.poll() is None for process in processes)
