"""An API and two workers that are started at the same moment on an empty Postgres, again and again."""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from postgres_server import PostgresServer

from jobs.home.home import Home

STARTS = int(os.environ.get("HGS_COLD_STARTS", "3"))

Poll = Callable[[Callable[[], bool], str], None]
Process = subprocess.Popen[bytes]


@pytest.fixture
def home(server: PostgresServer, tmp_path: Path) -> Home:
    return dataclasses.replace(Home.at(tmp_path / "home"), database_url=server.new_database())


@pytest.fixture
def start(home: Home, tmp_path: Path) -> Iterator[Callable[..., Process]]:
    processes: list[Process] = []

    def start(*command: str) -> Process:
        environment = {**os.environ, **home.environment()}
        with (tmp_path / "log").open("ab") as log:
            processes.append(
                subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, env=environment)
            )
        return processes[-1]

    yield start
    for process in processes:
        process.kill()
        process.wait()


@pytest.mark.slow
@pytest.mark.parametrize("_start", range(STARTS))
def test_all_are_ready(start: Callable[..., Process], wait_until: Poll, port: int, _start: int) -> None:
    began = time.monotonic()
    api = (str(Path(sys.executable).parent / "hgs"), "serve", "--workers", "0", "--port", str(port))
    worker = (sys.executable, "-m", "jobs.worker")
    processes = [start(*command) for command in (api, worker, worker)]

    def ready() -> bool:
        assert all(process.poll() is None for process in processes)
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{port}/readyz") as answer:
                return bool(json.load(answer)["workers"] == 2)
        except urllib.error.HTTPError as error:
            error.close()
        except OSError:
            pass
        return False

    wait_until(ready, "the API and both workers")
    print(f"ready after {time.monotonic() - began:.1f} s")
