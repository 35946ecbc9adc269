from __future__ import annotations

import asyncio
import json
import socket
from typing import Any

import pytest
import websockets

from hgs_core.base.errors import InputError
from server.access.allowed_hosts import AllowedHosts
from tests.server.conftest import running_server


@pytest.mark.parametrize(
    "host",
    ["localhost", "localhost:8000", "LOCALHOST.", "127.0.0.1:8000", "[::1]:8000", "[::1]", "192.168.1.7", "8.8.8.8:80"],
)
def test_loopback_and_addresses_are_allowed(host: str) -> None:
    assert AllowedHosts.configured(environment={}).allows(host)


@pytest.mark.parametrize(
    "host",
    [
        "evil.example",
        "evil.example:8000",
        "localhost.evil.example",
        "127.0.0.1.evil.example",
        "xlocalhost",
        "",
        "evil.example@localhost",
        "localhost:8000:80",
        "[::1",
        "[]",
        "[evil]",
        "127.1",
        "localhost/",
        "local host",
        "\xff",
    ],
)
def test_other_names_are_not(host: str) -> None:
    assert not AllowedHosts.configured(environment={}).allows(host)


def test_request_without_a_host_comes_from_no_page() -> None:
    assert AllowedHosts().allows(None)


def test_names_given_bound_to_and_in_the_environment_are_allowed() -> None:
    hosts = AllowedHosts.configured("nas.example", ["Münze.example"], {"HGS_ALLOW_HOSTS": "a.example, b.example"})
    for name in ("nas.example", "xn--mnze-0ra.example", "a.example", "B.example:80", "localhost"):
        assert hosts.allows(name)
    assert not hosts.allows("c.example")


def test_machine_answers_to_its_own_name_if_bound_to_all_addresses() -> None:
    name = socket.gethostname()
    assert AllowedHosts.configured("0.0.0.0", environment={}).allows(name)
    assert not AllowedHosts(frozenset({"localhost"})).allows("evil.example")


@pytest.mark.parametrize("name", ["http://a.example", "a.example:8000", "", "*", "a b"])
def test_what_is_no_name_is_bad_input(name: str) -> None:
    with pytest.raises(InputError, match=r"--allow-host or HGS_ALLOW_HOSTS: .* is not a host name"):
        AllowedHosts.configured(given=[name], environment={})


@pytest.mark.parametrize(
    ("method", "path"), [("GET", "/"), ("GET", "/v1/jobs"), ("POST", "/v1/jobs"), ("OPTIONS", "*"), ("GET", "/none")]
)
def test_request_to_another_host_is_told_the_cure(server: Any, method: str, path: str) -> None:
    headers = {"Host": "evil.example:8000", "Origin": "http://evil.example:8000"}
    response = server.request(method, path, headers=headers)
    assert (response.status_code, response.json()["code"]) == (421, "host-not-allowed")
    assert "'evil.example:8000'" in response.json()["detail"]
    assert "--allow-host" in response.json()["detail"]
    assert response.headers["x-content-type-options"] == "nosniff"
    assert server.jobs.requests == []


def test_stream_to_another_host_is_refused_before_the_upgrade(server: Any) -> None:
    async def scenario() -> None:
        async with running_server(server.app) as (_, address):
            port = address.partition(":")[2]
            with pytest.raises(websockets.InvalidStatus) as caught:
                await websockets.connect(
                    f"ws://evil.example:{port}/v1/scenes/studio/stream", host="127.0.0.1", port=int(port)
                )
            response = caught.value.response
            assert response.status_code == 421
            assert response.body is not None
            assert json.loads(response.body)["code"] == "host-not-allowed"

    asyncio.run(scenario())
