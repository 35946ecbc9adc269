"""Captures that were made to do harm, submitted to a server that runs: each is refused, and the server stays."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from tests.conftest import REPOSITORY
from tests.server.hostile_captures import HOSTILE, write_still

WORST = (
    "concat of itself",
    "concat of itself with poses",
    "npy of 1e9 rows",
    "objects 100,000 deep",
    "sync 100,000 deep",
    "toml 100,000 deep",
    "picture of 60,000^2",
)
STACK = 2500 << 10  # bytes: an opened file that opens itself ends with it before it ends with descriptors
FILES = 20_000


@pytest.fixture
def client(tmp_path: Path) -> Iterator[httpx.Client]:
    """A server of its own process, with little stack; its captures are in `captures`."""
    environment = {**os.environ, "HGS_HOME": str(tmp_path / "home"), "HGS_CAPTURES": str(tmp_path / "captures")}
    environment["HGS_STAGE_FILES"] = str(FILES)

    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_STACK, (STACK, STACK))

    process = subprocess.Popen(
        [sys.executable, "-m", "server.cli", "serve", "--workers", "0", "--port", "0"],
        cwd=REPOSITORY,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        preexec_fn=limited,
    )
    try:
        assert process.stdout is not None
        address = process.stdout.readline().strip().rstrip("/")
        with httpx.Client(base_url=address, timeout=600) as client:
            yield client
            assert process.poll() is None, "the server has ended"
            assert client.get("/readyz").status_code == 200
            maps = Path(f"/proc/{process.pid}/maps")
            loaded = maps.read_text() if maps.exists() else ""
            assert "libavformat" not in loaded
            assert "_imaging" not in loaded  # Pillow's
    finally:
        process.kill()
        process.communicate()


@pytest.fixture
def submit(client: httpx.Client) -> Callable[[str], httpx.Response]:
    """Return a function that submits a capture, and asks until it has been looked at."""

    def until_looked_at(capture: str) -> httpx.Response:
        answer = client.post("/v1/jobs", json={"capture": capture})
        while answer.status_code == 202:
            time.sleep(float(answer.headers["Retry-After"]))
            answer = client.get(answer.url.join(answer.headers["Location"]))
        return answer

    return until_looked_at


def assert_refused(answer: httpx.Response, capture: str, tmp_path: Path) -> None:
    problem: dict[str, Any] = answer.json()
    assert answer.status_code == 422, problem
    assert (problem["code"], problem["field"]) == ("capture-invalid", "capture")
    assert problem["detail"].startswith(capture)
    assert str(tmp_path) not in problem["detail"]  # no path of the server's disk


def write(tmp_path: Path, names: tuple[str, ...]) -> None:
    for name in ("well", *names):
        (tmp_path / "captures" / name).mkdir(parents=True)
        HOSTILE.get(name, write_still)(tmp_path / "captures" / name)


def assert_all_refused(submit: Callable[[str], httpx.Response], tmp_path: Path, names: tuple[str, ...]) -> None:
    write(tmp_path, names)
    for name in names:
        assert_refused(submit(name), name, tmp_path)
    assert submit("well").json()["state"] == "queued"


def test_the_worst_of_them_are_refused_and_the_server_stays(
    submit: Callable[[str], httpx.Response], tmp_path: Path
) -> None:
    assert_all_refused(submit, tmp_path, WORST)


@pytest.mark.slow
def test_all_of_them_are_refused_and_listed_and_the_server_stays(
    client: httpx.Client, submit: Callable[[str], httpx.Response], tmp_path: Path
) -> None:
    assert_all_refused(submit, tmp_path, tuple(HOSTILE))
    listed = client.get("/v1/captures").json()["captures"]
    while any(one["looking"] for one in listed):
        time.sleep(0.5)
        listed = client.get("/v1/captures").json()["captures"]
    assert {one["name"] for one in listed} == {"well", *HOSTILE}
    assert not Path("/tmp/hgs-hostile-pickle-was-run").exists()
    (odd,) = [one for one in listed if one["name"] == "concat of itself"]
    assert "cam0.mp4" in odd["problem"]
