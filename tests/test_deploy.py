"""The files of deploy/: the configuration of nginx with a server behind it, and the units as systemd reads them."""

from __future__ import annotations

import asyncio
import hashlib
import json
import os
import re
import shlex
import shutil
import ssl
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from urllib.parse import urljoin, urlsplit

import httpx
import pytest
import websockets

from jobs.home.home import Home
from jobs.records.keys import KeyTable, Scope
from server.cli import main, serve, worker
from server.protocol.messages import Hello, encode
from tests.conftest import REPOSITORY
from tests.nginx import free_ports, running_nginx
from tests.server.conftest import chunks, manifest, scene_folder  # noqa: F401  (fixtures)
from tests.server.listener.test_http_server import receive

DEPLOY = REPOSITORY / "deploy"
NAME = "scenes.example.org"


@contextmanager
def behind_nginx(folder: Path, port: int) -> Iterator[tuple[str, ssl.SSLContext]]:
    """Run nginx with our configuration, but for ports, files and the certificate's name; yield its address."""
    if shutil.which("openssl") is None:
        pytest.skip("openssl is not installed: apt-get install openssl")
    key, certificate = folder / "key.pem", folder / "certificate.pem"
    subprocess.run(
        [
            "openssl",
            "req",
            "-x509",
            "-newkey",
            "ec",
            "-pkeyopt",
            "ec_paramgen_curve:prime256v1",
            "-nodes",
            "-days",
            "1",
            "-subj",
            f"/CN={NAME}",
            "-addext",
            "subjectAltName=IP:127.0.0.1",
            "-keyout",
            key,
            "-out",
            certificate,
        ],
        check=True,
        capture_output=True,
    )
    plain, secure = free_ports(2)
    text = (DEPLOY / "nginx.conf").read_text()
    for ours, here in (
        ("listen 80;", f"listen 127.0.0.1:{plain};"),
        ("listen 443 ssl", f"listen 127.0.0.1:{secure} ssl"),
        (f"/etc/letsencrypt/live/{NAME}/fullchain.pem", str(certificate)),
        (f"/etc/letsencrypt/live/{NAME}/privkey.pem", str(key)),
        ("/var/log/nginx/hgs.log", str(folder / "access.log")),
        ("http://127.0.0.1:8000", f"http://127.0.0.1:{port}"),
    ):
        assert ours in text, ours
        text = text.replace(ours, here)
    with running_nginx(folder, text, [secure]):
        yield f"127.0.0.1:{secure}", ssl.create_default_context(cafile=str(certificate))


@contextmanager
def serving(run: Path, home: Path, *options: str) -> Iterator[int]:
    """Serve a run in a process of its own; gives the port."""
    [port] = free_ports(1)
    command = [sys.executable, "-m", "server.cli", "serve", run, "--port", str(port), "--workers", "0", *options]
    server = subprocess.Popen(
        command, env=os.environ | {"HGS_HOME": str(home)}, cwd=REPOSITORY, stdout=subprocess.PIPE, text=True
    )
    try:
        assert server.stdout is not None
        server.stdout.readline()
        yield port
    finally:
        server.terminate()
        server.communicate(timeout=30)


def test_pages_chunks_and_streams_come_through_nginx_to_who_has_a_key(
    scene_folder: Path,  # noqa: F811
    chunks: list[bytes],  # noqa: F811
    tmp_path: Path,
) -> None:
    home = tmp_path / "home"
    with closing(KeyTable(Home.at(home))) as table:
        key = table.add("anna", {Scope.VIEW})
    with (
        serving(scene_folder, home) as port,
        behind_nginx(tmp_path, port) as (address, trust),
        httpx.Client(verify=trust) as client,
    ):
        base = f"https://{address}"
        assert client.get(f"{base}/v1/scenes").status_code == 401
        begun = client.post(f"{base}/v1/session", json={"key": key}, headers={"Origin": base})
        assert begun.status_code == 204
        assert "Secure" in begun.headers["Set-Cookie"]
        assert client.get(f"{base}/v1/scenes/studio-run").json()["title"] == "Studio"
        chunk = client.get(f"{base}/v1/chunks/{hashlib.sha256(chunks[0]).hexdigest()}")
        assert (chunk.content, chunk.headers["Strict-Transport-Security"]) == (chunks[0], "max-age=31536000")
        assert client.get(f"{base}/metrics").status_code == 404

        async def stream() -> None:
            url, bearer = f"wss://{address}/v1/scenes/studio-run/stream", {"Authorization": f"Bearer {key}"}
            async with websockets.connect(url, ssl=trust, additional_headers=bearer, origin=base) as viewer:  # type: ignore[arg-type]
                await viewer.send(encode(Hello(1, 4144)))
                await receive(viewer)

        asyncio.run(stream())
        log = (tmp_path / "access.log").read_text()
        assert f'"GET /v1/chunks/{hashlib.sha256(chunks[0]).hexdigest()}" 200' in log


def document_blocks() -> dict[str, str]:
    """The configurations of nginx in docs/deploy.md, by the first line's comment."""
    found = re.findall(r"```nginx\n# (.+?)\n(.*?)```", (REPOSITORY / "docs" / "deploy.md").read_text(), re.DOTALL)
    return dict(found)


@contextmanager
def proxied(folder: Path, block: str, port: int) -> Iterator[int]:
    """Run nginx with lines of a `server` block before the server at a port; gives its own."""
    [proxy] = free_ports(1)
    text = block.replace("http://127.0.0.1:8000", f"http://127.0.0.1:{port}")
    assert text != block
    with running_nginx(folder, f"access_log off; server {{ listen 127.0.0.1:{proxy}; {text} }}", [proxy]):
        yield proxy


@pytest.mark.parametrize(
    ("name", "root", "options", "streams"),
    [
        ("deploy/nginx-prefix.conf", "/hgs", (), True),
        ("with hgs serve --root-path /hgs", "/hgs", ("--root-path", "/hgs"), True),
        ("without WebSockets", "", (), False),
    ],
)
def test_other_configurations_bring_a_scene_too(
    name: str,
    root: str,
    options: tuple[str, ...],
    streams: bool,
    scene_folder: Path,  # noqa: F811
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    block = (REPOSITORY / name).read_text() if name.endswith(".conf") else document_blocks()[name]
    with serving(scene_folder, tmp_path / "home", "--open", *options) as port, proxied(tmp_path, block, port) as proxy:
        base = f"http://127.0.0.1:{proxy}{root}"
        made = httpx.post(f"{base}/v1/uploads", json={"name": "a", "files": 1, "bytes": 1})
        at = httpx.get(urljoin(str(made.url), made.headers["Location"]))
        assert (at.status_code, at.json()["id"]) == (200, made.json()["id"])
        assert httpx.get(f"{base}/v1/scenes/none").json()["instance"].startswith("/v1" if not root else f"{root}/v1")
        assert httpx.get(f"{base}/metrics").status_code == (404 if name.endswith(".conf") else 200)
        if root:
            redirected = httpx.get(base)
            assert urlsplit(urljoin(base, redirected.headers["Location"])).path == f"{root}/"
        capsys.readouterr()
        assert main(["play", f"{base}/view/studio-run", "--stats", "--json", "--seconds", "1"]) == 0
        told = capsys.readouterr()
        assert json.loads(told.out)["over_http"] is not streams
        assert len(told.err.splitlines()) == (0 if streams else 1)
        assert json.loads(told.out)["bytes"] > 0


def test_a_key_opens_a_scene_without_websockets(
    scene_folder: Path,  # noqa: F811
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    home = tmp_path / "home"
    with closing(KeyTable(Home.at(home))) as table:
        key = table.add("anna", {Scope.PUBLISH, Scope.VIEW})
    block = document_blocks()["without WebSockets"]
    with serving(scene_folder, home) as port, proxied(tmp_path, block, port) as proxy:
        page = f"http://127.0.0.1:{proxy}/view/studio-run"
        arguments = ["--stats", "--json", "--seconds", "1"]
        assert main(["play", page, *arguments]) == 2
        assert "set HGS_KEY to a key of that server" in capsys.readouterr().err
        bearer = {"Authorization": f"Bearer {key}"}
        made = httpx.post(
            f"http://127.0.0.1:{proxy}/v1/links", json={"scene": "studio-run", "seconds": 600}, headers=bearer
        ).json()
        assert main(["play", f"{page}?link={made['link']}", *arguments]) == 0
        assert json.loads(capsys.readouterr().out)["bytes"] > 0
        monkeypatch.setenv("HGS_KEY", key)
        assert main(["play", page, *arguments]) == 0
        assert json.loads(capsys.readouterr().out)["bytes"] > 0


@pytest.mark.parametrize(("unit", "module"), [("hgs.service", serve), ("hgs-worker@.service", worker)])
def test_a_unit_starts_a_command_that_there_is(unit: str, module: object) -> None:
    import argparse

    [line] = [line for line in (DEPLOY / unit).read_text().splitlines() if line.startswith("ExecStart=")]
    program, *arguments = shlex.split(line.partition("=")[2])
    assert program == "/opt/hgs/bin/hgs"
    parser = argparse.ArgumentParser()
    module.add_parser(parser.add_subparsers())  # type: ignore[attr-defined]
    parser.parse_args(arguments)
