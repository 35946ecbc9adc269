from __future__ import annotations

from typing import Any

from hgs_core.base.version import software_version


def test_health_names_the_version_and_the_protocol(server: Any) -> None:
    assert server.get("/v1/health").json() == {"status": "ok", "version": software_version(), "protocol": 1}


def test_health_is_answered_while_the_queue_and_the_store_are_away(server: Any) -> None:
    server.jobs.refuse = OSError("no queue")
    server.artifacts.manifests = server.artifacts.chunks = None
    assert server.get("/v1/health").status_code == server.request("HEAD", "/v1/health").status_code == 200
