"""`hgs serve` as a process: its page, its API, its worker, and how it stops."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest

from jobs.liveness import FileLiveness

REPOSITORY = Path(__file__).resolve().parents[3]
MODULES = Path(__file__).resolve().parent.parent / "modules"


@contextlib.contextmanager
def serving(home: Path, *arguments: object, **environment: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """Run `hgs serve` on a port of the system's choice; yield the process and the address of the page it prints."""
    process = subprocess.Popen(
        [sys.executable, "-m", "server.cli", "serve", *map(str, arguments), "--port", "0"],
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
