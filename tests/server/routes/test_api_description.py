from __future__ import annotations

import re
from typing import Any

import pytest

from tests.conftest import REPOSITORY
from tests.server.conftest import Server


@pytest.fixture
def described(server: Server) -> dict[str, Any]:
    found: dict[str, Any] = server.get("/openapi.json").json()
    return found


def test_every_body_that_a_route_reads_is_described(described: dict[str, Any]) -> None:
    """As many as the routes read by `read_json`, which FastAPI does not see."""
    bodies = [
        operation["requestBody"]["content"]["application/json"]["schema"]
        for operations in described["paths"].values()
        for operation in operations.values()
        if "requestBody" in operation
    ]
    sources = (REPOSITORY / "server" / "routes").glob("*.py")
    assert len(bodies) == sum(len(re.findall(r"\bread_json\(request, \w+", path.read_text())) for path in sources)
    assert all(body["properties"] for body in bodies)


def test_every_reference_leads_to_a_schema(described: dict[str, Any]) -> None:
    names = set(re.findall(r"#/components/schemas/(\w+)", str(described)))
    assert names
    assert names <= set(described["components"]["schemas"])


def test_operations_have_names_of_their_own_and_say_what_key_they_need(described: dict[str, Any]) -> None:
    operations = [operation for path in described["paths"].values() for operation in path.values()]
    assert len({operation["operationId"] for operation in operations}) == len(operations) > 40
    paths = described["paths"]
    assert "Requires the scope `submit`." in paths["/v1/jobs"]["post"]["description"]
    assert paths["/v1/jobs/{job_id}"]["get"]["security"] == [{"key": []}]
    assert "security" not in paths["/v1/health"]["get"]
    assert "Requires the scope `view`." in paths["/v1/scenes/{scene_id}/manifest"]["get"]["description"]


def test_the_viewers_files_are_no_part_of_it(described: dict[str, Any]) -> None:
    assert all(path.startswith("/v1/") or (path.count("/") == 1 and "{" not in path) for path in described["paths"])
