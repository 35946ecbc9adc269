"""A server that speaks S3, for tests: moto's, where it is installed. It forgets everything when it ends."""

from __future__ import annotations

import shutil
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest


def missing_program() -> str:
    """Return why no server can be started here; "" if one can."""
    return "" if _program() else "moto_server is missing: pip install 'moto[s3]' flask flask-cors to run these tests"


def _program() -> str | None:
    return shutil.which("moto_server", path=str(Path(sys.executable).parent)) or shutil.which("moto_server")


class S3Server:
    """Has its address from the beginning, and answers there, with a bucket named "bucket", while it is started."""

    def __init__(self) -> None:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self._port = probe.getsockname()[1]
        self.address = f"http://127.0.0.1:{self._port}"
        self.settings = {
            "AWS_ENDPOINT": self.address,
            "AWS_ALLOW_HTTP": "true",
            "AWS_REGION": "us-east-1",
            "AWS_ACCESS_KEY_ID": "test",
            "AWS_SECRET_ACCESS_KEY": "test",
        }
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        program = _program()
        assert program is not None
        quiet = subprocess.DEVNULL
        command = [program, "-H", "127.0.0.1", "-p", str(self._port)]
        self._process = subprocess.Popen(command, stdout=quiet, stderr=quiet)
        bucket = urllib.request.Request(f"{self.address}/bucket", method="PUT")
        deadline = time.monotonic() + 120
        while True:
            try:
                urllib.request.urlopen(bucket).close()
                return
            except OSError:
                assert time.monotonic() < deadline, "the S3 server does not answer"
                time.sleep(0.05)

    def stop(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None


@contextmanager
def running_s3_server() -> Iterator[S3Server]:
    """Start one for the block; skip the test where there is none."""
    if missing := missing_program():
        pytest.skip(missing)
    server = S3Server()
    server.start()
    try:
        yield server
    finally:
        server.stop()
