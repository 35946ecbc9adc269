"""A real nginx for tests, with the configuration that each of them writes."""

from __future__ import annotations

import shutil
import signal
import socket
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

__all__ = ["free_ports", "running_nginx"]


def free_ports(count: int) -> list[int]:
    """Ports that nobody has, all of them others."""
    with ExitStack() as stack:
        probes = [stack.enter_context(socket.socket()) for _ in range(count)]
        for probe in probes:
            probe.bind(("127.0.0.1", 0))
        return [int(probe.getsockname()[1]) for probe in probes]


@contextmanager
def running_nginx(folder: Path, text: str, ports: Sequence[int]) -> Iterator[None]:
    """Run nginx with `text` in its block `http` until all `ports` are open; the test is skipped where there is none."""
    nginx = shutil.which("nginx") or shutil.which("nginx", path="/usr/sbin")
    if nginx is None:
        pytest.skip("nginx is not installed: apt-get install nginx-light")
    temporary = "".join(
        f"{name}_temp_path {folder}/{name};" for name in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi")
    )
    config, errors = folder / "nginx.conf", folder / "error.log"
    config.write_text(
        f"daemon off; master_process off; pid {folder}/nginx.pid; error_log {errors};"
        f"events {{}} http {{ {temporary}\n{text} }}"
    )
    subprocess.run([nginx, "-t", "-q", "-c", config, "-e", errors], check=True)
    process = subprocess.Popen([nginx, "-c", config, "-e", errors])
    try:
        for port in ports:
            while True:
                with socket.socket() as probe:
                    if probe.connect_ex(("127.0.0.1", port)) == 0:
                        break
                assert process.poll() is None, errors.read_text()
        yield
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(30)
