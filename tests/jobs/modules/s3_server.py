"""A server that speaks S3, for tests: moto's, where it is installed. It forgets everything when it ends."""

from __future__ import annotations

import io
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from typing import Any

import pytest


def missing_program() -> str:
    """Return why no server can be started here; "" if one can."""
    found = all(find_spec(name) for name in ("moto", "flask", "flask_cors"))
    return "" if found else "moto is missing: pip install 'moto[s3]' flask flask-cors to run these tests"


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
        quiet = subprocess.DEVNULL
        command = [sys.executable, __file__, str(self._port)]
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


class OneConditionalPut:
    """Moto's application with conditional puts one after the other: its own can both see that there is no object."""

    def __init__(self, application: Any) -> None:
        self._application = application
        self._lock = threading.Lock()

    def __call__(self, environ: dict[str, Any], start_response: Any) -> Iterable[bytes]:
        if environ["REQUEST_METHOD"] != "PUT" or not {"HTTP_IF_MATCH", "HTTP_IF_NONE_MATCH"} & environ.keys():
            answer: Iterable[bytes] = self._application(environ, start_response)
            return answer
        body = environ["wsgi.input"].read(int(environ.get("CONTENT_LENGTH") or 0))  # a slow sender holds no lock
        environ["wsgi.input"] = io.BytesIO(body)
        with self._lock:
            return list(self._application(environ, start_response))


def main(port: int) -> None:
    from moto.server import DomainDispatcherApplication, MotoRequestHandler, create_backend_app
    from werkzeug.serving import run_simple

    application = OneConditionalPut(DomainDispatcherApplication(create_backend_app))
    run_simple("127.0.0.1", port, application, threaded=True, request_handler=MotoRequestHandler)


if __name__ == "__main__":
    main(int(sys.argv[1]))
