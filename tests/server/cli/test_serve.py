"""`hgs serve` as a process: its page, its API, its worker, and how it stops."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import resource
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from urllib.parse import urlsplit

import httpx
import pytest

from jobs.home.home import Home
from jobs.queue.liveness import FileLiveness
from jobs.records.keys import KeyTable, Scope

REPOSITORY = Path(__file__).resolve().parents[3]
MODULES = Path(__file__).resolve().parent.parent / "modules"


@contextlib.contextmanager
def serving(
    home: Path, *arguments: object, shell: str = "true", **environment: str
) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """Run `hgs serve` on a port of the system's choice; yield the process and the address of the page it prints.

    The commands `shell` are run in its process first, such as `ulimit`.
    """
    command = [sys.executable, "-m", "server.cli", "serve", *map(str, arguments), "--port", "0"]
    process = subprocess.Popen(
        ["bash", "-c", f'{shell} && exec "$@"', "bash", *command],
        cwd=REPOSITORY,
        env={**os.environ, "HGS_HOME": str(home), **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout is not None
        yield process, process.stdout.readline().strip()
    finally:
        process.kill()
        process.communicate()


@pytest.mark.parametrize(("number", "status"), [(signal.SIGTERM, 143), (signal.SIGINT, 130)])
def test_publishes_serves_and_stops_on_a_signal(
    scene_folder: Path, tmp_path: Path, number: signal.Signals, status: int
) -> None:
    with serving(tmp_path / "home", scene_folder, "--workers", 0) as (process, page):
        address = page.removesuffix("/view/studio-run")
        assert address.startswith("http://127.0.0.1:")
        assert address != page
        assert httpx.get(f"{address}/v1/scenes/studio-run").json()["title"] == "Studio"
        process.send_signal(number)
        _, errors = process.communicate(timeout=60)
        assert process.returncode == status
        assert "Traceback" not in errors


def test_submitted_capture_becomes_a_scene_and_no_worker_is_left(
    scene_folder: Path, tmp_path: Path, chunks: list[bytes], manifest: bytes
) -> None:
    modules = {"HGS_PIPELINE": "ready_pipeline", "PYTHONPATH": os.pathsep.join((str(MODULES), str(REPOSITORY)))}
    with serving(tmp_path / "home", "--captures", tmp_path, **modules) as (process, page):
        with httpx.Client(base_url=page, timeout=60) as client:
            answer = client.post("v1/jobs", json={"capture": scene_folder.name, "title": "Copy"})
            assert answer.status_code == 201, answer.text
            job = answer.json()
            with client.stream("GET", f"v1/jobs/{job['id']}/events") as events:
                for line in events.iter_lines():
                    if line.startswith("data: "):
                        job = json.loads(line.removeprefix("data: "))
            assert (job["state"], job["scene"], job["error"]) == ("succeeded", job["id"], None)
            assert client.get(f"v1/scenes/{job['scene']}").json()["title"] == "Copy"
            assert client.get(f"v1/scenes/{job['scene']}/manifest").content == manifest
            chunk = hashlib.sha256(chunks[0]).hexdigest()
            assert client.get(f"v1/chunks/{chunk}").content == chunks[0]
        (worker,) = (path.name for path in (tmp_path / "home" / "live").iterdir() if not path.name.startswith("."))
        process.terminate()
        process.communicate(timeout=60)
    with FileLiveness(tmp_path / "home" / "live").claim_dead(worker) as dead:
        assert dead


def test_idle_connections_keep_nobody_out_and_do_not_fill_the_log(tmp_path: Path) -> None:
    with serving(tmp_path, "--workers", 0, shell="ulimit -n 256") as (process, page), contextlib.ExitStack() as stack:
        address = urlsplit(page)
        assert address.hostname is not None
        assert address.port is not None
        for k in range(300):
            client = stack.enter_context(socket.create_connection((address.hostname, address.port), timeout=60))
            if k % 2:
                client.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\nX-Slow: ")
        for _ in range(10):
            assert httpx.get(f"{page}v1/health", timeout=60).status_code == 200
        process.terminate()
        _, errors = process.communicate(timeout=60)
    assert errors.count("closed the connection that waited longest") == 1
    assert len(errors.splitlines()) < 10


def test_serves_with_as_many_files_as_the_system_allows(tmp_path: Path) -> None:
    with serving(tmp_path, "--workers", 0, shell="ulimit -S -n 200 && ulimit -H -n 400") as (process, _):
        assert resource.prlimit(process.pid, resource.RLIMIT_NOFILE) == (400, 400)


def test_answers_to_the_names_it_is_given(tmp_path: Path) -> None:
    names = ("--allow-host", "hgs.example", "--workers", 0)
    with serving(tmp_path, *names, HGS_ALLOW_HOSTS="other.example") as (_, page):
        for host, status in (("hgs.example", 200), ("other.example:80", 200), ("evil.example", 421)):
            assert httpx.get(f"{page}v1/health", headers={"Host": host}).status_code == status


def test_a_server_that_others_can_reach_needs_keys_or_to_be_called_open(tmp_path: Path) -> None:
    everywhere = ("--host", "0.0.0.0", "--workers", 0)
    home = tmp_path / "home"
    with serving(home, *everywhere, HGS_OPEN="") as (process, _):
        _, errors = process.communicate(timeout=60)
        assert process.returncode == 2
        assert "--host: 0.0.0.0 is reached by others, and there are no keys; make a key with hgs keys add" in errors
    with serving(home, *everywhere, "--open") as (process, page):
        assert httpx.get(f"{page}v1/scenes").status_code == 200
        process.terminate()
        assert "open: whoever can reach this server can use all of it" in process.communicate(timeout=60)[1]
    with closing(KeyTable(Home.at(home))) as keys:
        bearer = {"Authorization": f"Bearer {keys.add('anna', {Scope.VIEW})}"}
    with serving(home, *everywhere, HGS_OPEN="") as (_, page):
        assert httpx.get(f"{page}v1/scenes").status_code == 401
        assert httpx.get(f"{page}v1/scenes", headers=bearer).status_code == 200


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        (["--max-streams", "0"], "--max-streams: 0 is too few"),
        (["--requests-per-second", "0"], "--requests-per-second: 0.0 is no limit"),
        (["--drain", "1e9"], "is no number of seconds; give 0 to 300"),
    ],
)
def test_bad_limits_are_refused(refused: Callable[..., str], options: list[str], problem: str) -> None:
    assert problem in refused("serve", "--port", 0, *options)


def test_a_kernel_without_a_sandbox_is_named_at_the_start(tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text("from jobs.process import landlock; landlock.landlock_version = int")
    path = os.pathsep.join((str(tmp_path), str(REPOSITORY)))
    with serving(tmp_path / "home", "--workers", 0, PYTHONPATH=path) as (process, _):
        process.terminate()
        assert process.communicate(timeout=60)[1].count("hgs: no sandbox: this kernel has no Landlock") == 1


def test_the_root_of_a_proxy_is_taken_from_options_and_environment(tmp_path: Path) -> None:
    with serving(tmp_path, "--workers", "0", HGS_ROOT_PATH="/my%20scenes/hgs") as (_, page):
        assert httpx.get(f"{page}my%20scenes/hgs/v1/health").status_code == 200
        assert httpx.get(f"{page}v1/health").status_code == 200
    with serving(tmp_path, "--workers", "0", "--root-path", "/a/../b") as (process, page):
        assert process.wait(60) == 2
        assert process.stderr is not None
        assert "hgs: --root-path" in process.stderr.read()
