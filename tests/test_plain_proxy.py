"""A server without keys behind real proxies with nothing but its address in their configuration."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import httpx
import pytest

from jobs.home.home import Home
from jobs.records.keys import KeyTable, Scope
from tests.conftest import REPOSITORY
from tests.nginx import free_ports

NEW = "proxy_http_version 1.1;"
QUIET = f'{NEW} proxy_set_header Connection "";'  # nothing shows it; docs/access.md says so
STREAMS = f"{NEW} proxy_set_header Upgrade $http_upgrade; proxy_set_header Connection"
# What people write into `location`, beside `proxy_pass`.
CONFIGURATIONS = {
    "nothing": "",
    "HTTP/1.1": NEW,
    "for WebSockets": f'{STREAMS} "upgrade";',
    "as nginx's page on WebSockets": f"{STREAMS} $connection_upgrade;",
    "the client's address alone": f"{QUIET} proxy_set_header X-Real-IP $remote_addr;",
    "the client's name of us": f"{QUIET} proxy_set_header Host 192.0.2.1;",
    "Via": f'{QUIET} proxy_set_header Via "1.1 nginx";',
}
ASKED = [
    ("GET", "/v1/jobs"),
    ("POST", "/v1/jobs"),
    ("GET", "/v1/scenes"),
    ("DELETE", "/v1/scenes/a"),
    ("GET", "/metrics"),
]


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("home")


@pytest.fixture(scope="module")
def served(home: Path) -> Iterator[tuple[int, str]]:
    """The port of a server on a home without keys, and its output."""
    command = [sys.executable, "-m", "server.cli", "serve", "--port", "0", "--workers", "0"]
    environment = os.environ | {"HGS_HOME": str(home)}
    log = home / "log"
    with log.open("wb") as errors:
        server = subprocess.Popen(
            command, env=environment, cwd=REPOSITORY, stdout=subprocess.PIPE, stderr=errors, text=True
        )
    try:
        assert server.stdout is not None
        port = int(server.stdout.readline().strip().rstrip("/").rpartition(":")[2])
        yield port, log.read_text()
    finally:
        server.terminate()
        server.communicate(timeout=30)


@pytest.fixture(scope="module")
def proxied(served: tuple[int, str], tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    """The addresses of nginx, one for each configuration."""
    nginx = shutil.which("nginx") or shutil.which("nginx", path="/usr/sbin")
    if nginx is None:
        pytest.skip("nginx is not installed: apt-get install nginx-light")
    folder = tmp_path_factory.mktemp("nginx")
    upstream = f"http://127.0.0.1:{served[0]}"
    names = (*CONFIGURATIONS, "unseen")
    ports = dict(zip(names, free_ports(len(names)), strict=True))
    servers = "".join(
        f"server {{ listen 127.0.0.1:{ports[name]}; location / {{ proxy_pass {upstream}; {more} }} }}\n"
        for name, more in (CONFIGURATIONS | {"unseen": QUIET}).items()
    )
    kinds = ("client_body", "proxy", "fastcgi", "uwsgi", "scgi")
    temporary = "".join(f"{name}_temp_path {folder}/{name};" for name in kinds)
    config = folder / "nginx.conf"
    config.write_text(
        f"daemon off; master_process off; pid {folder}/nginx.pid; error_log {folder}/error.log; events {{}}\n"
        f"http {{ access_log off; {temporary} map $http_upgrade $connection_upgrade {{ default upgrade; '' close; }}\n"
        f"{servers} }}"
    )
    process = subprocess.Popen([nginx, "-c", config, "-e", folder / "error.log"])
    try:
        while True:
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", ports["unseen"])) == 0:
                    break
            assert process.poll() is None, (folder / "error.log").read_text()
        yield {name: f"http://127.0.0.1:{port}" for name, port in ports.items()}
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(30)


@pytest.mark.parametrize("configuration", CONFIGURATIONS)
def test_nobody_is_let_in_through_a_proxy_and_the_answer_says_how_to_make_a_key(
    configuration: str, proxied: dict[str, str]
) -> None:
    with httpx.Client(base_url=proxied[configuration], headers={"User-Agent": "curl/8"}) as client:
        for method, path in ASKED:
            answer = client.request(method, path)
            assert (answer.status_code, answer.json()["code"]) == (401, "key-needed"), (method, path)
            assert "hgs keys add NAME --scope admin" in answer.json()["detail"]
        assert client.get("/v1/session").json()["needed"]
        assert client.get("/healthz").status_code == 200


def test_asked_directly_it_is_open_and_has_said_so(served: tuple[int, str]) -> None:
    port, said = served
    for host in ("127.0.0.1", "localhost"):
        with httpx.Client(base_url=f"http://{host}:{port}") as client:
            assert client.get("/v1/jobs").status_code == 200
    assert "no keys: whoever asks from this machine can use all of this server; before a proxy" in said


def test_with_the_first_key_a_proxy_that_shows_nothing_lets_nobody_in_either(
    proxied: dict[str, str], home: Path
) -> None:
    with httpx.Client(base_url=proxied["unseen"]) as client:
        assert client.get("/v1/jobs").status_code == 200
        with closing(KeyTable(Home.at(home))) as table:
            key = table.add("anna", {Scope.ADMIN})
        while (answer := client.get("/v1/jobs")).status_code == 200:  # keys are kept for a second
            pass
        assert "hgs keys add" not in answer.json()["detail"]  # there are keys
        assert client.get("/v1/jobs", headers={"Authorization": f"Bearer {key}"}).status_code == 200
