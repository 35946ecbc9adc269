"""The files of deploy/: the configuration of nginx with a server behind it, and the units as systemd reads them."""

from __future__ import annotations

import asyncio
import hashlib
import os
import shlex
import shutil
import signal
import socket
import ssl
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import httpx
import pytest
import websockets

from jobs.home import Home
from jobs.keys import KeyTable, Scope
from server.cli import serve, worker
from server.protocol import Hello, encode
from tests.conftest import REPOSITORY
from tests.server.conftest import chunks, manifest, scene_folder  # noqa: F401  (fixtures)
from tests.server.test_serving import receive

DEPLOY = REPOSITORY / "deploy"
NAME = "scenes.example.org"


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextmanager
def behind_nginx(folder: Path, port: int) -> Iterator[tuple[str, ssl.SSLContext]]:
    """Run nginx with our configuration, but for ports, files and the certificate's name; yield its address."""
    nginx = shutil.which("nginx") or shutil.which("nginx", path="/usr/sbin")
    if nginx is None or shutil.which("openssl") is None:
        pytest.skip("nginx or openssl is not installed: apt-get install nginx-light openssl")
    key, certificate = folder / "key.pem", folder / "certificate.pem"
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "1",
         "-subj", f"/CN={NAME}", "-addext", "subjectAltName=IP:127.0.0.1", "-keyout", key, "-out", certificate],
        check=True, capture_output=True,
    )  # fmt: skip
    plain, secure = free_port(), free_port()
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
    temporary = "".join(
        f"{name}_temp_path {folder}/{name};" for name in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi")
    )
    config = folder / "nginx.conf"
    config.write_text(
        f"daemon off; master_process off; pid {folder}/nginx.pid; error_log {folder}/error.log;"
        f"events {{}} http {{ {temporary}\n{text} }}"
    )
    subprocess.run([nginx, "-t", "-q", "-c", config, "-e", folder / "error.log"], check=True)
    process = subprocess.Popen([nginx, "-c", config, "-e", folder / "error.log"])
    try:
        while True:
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", secure)) == 0:
                    break
            assert process.poll() is None, (folder / "error.log").read_text()
        yield f"127.0.0.1:{secure}", ssl.create_default_context(cafile=str(certificate))
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(30)


def test_pages_chunks_and_streams_come_through_nginx_to_who_has_a_key(
    scene_folder: Path,  # noqa: F811
    chunks: list[bytes],  # noqa: F811
    tmp_path: Path,
) -> None:
    home = tmp_path / "home"
    with closing(KeyTable(Home.at(home))) as table:
        key = table.add("anna", {Scope.VIEW})
    port = free_port()
    command = [sys.executable, "-m", "server.cli", "serve", scene_folder, "--port", str(port), "--workers", "0"]
    server = subprocess.Popen(
        command, env=os.environ | {"HGS_HOME": str(home)}, cwd=REPOSITORY, stdout=subprocess.PIPE, text=True
    )
    try:
        assert server.stdout is not None
        server.stdout.readline()
        with behind_nginx(tmp_path, port) as (address, trust), httpx.Client(verify=trust) as client:
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
                    await viewer.send(encode(Hello(2, 4144)))
                    await receive(viewer)

            asyncio.run(stream())
            log = (tmp_path / "access.log").read_text()
            assert f'"GET /v1/chunks/{hashlib.sha256(chunks[0]).hexdigest()}" 200' in log
    finally:
        server.terminate()
        server.communicate(timeout=30)


@pytest.mark.parametrize(("unit", "module"), [("hgs.service", serve), ("hgs-worker@.service", worker)])
def test_a_unit_starts_a_command_that_there_is(unit: str, module: object) -> None:
    import argparse

    [line] = [line for line in (DEPLOY / unit).read_text().splitlines() if line.startswith("ExecStart=")]
    program, *arguments = shlex.split(line.partition("=")[2])
    assert program == "/opt/hgs/bin/hgs"
    parser = argparse.ArgumentParser()
    module.add_parser(parser.add_subparsers())  # type: ignore[attr-defined]
    parser.parse_args(arguments)
