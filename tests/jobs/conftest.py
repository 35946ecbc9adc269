"""A home of its own for every test, a pipeline that only counts, and workers that are real processes."""

from __future__ import annotations

import dataclasses
import os
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa

sys.path.insert(0, str(Path(__file__).parent / "modules"))  # helpers of tests, and pipelines

from postgres_server import PostgresServer, missing_program

from hgs_core.runs.run_config import RunConfig
from jobs.artifacts.artifact_store import ArtifactStore, open_store
from jobs.home.database import create_engine, prepare_database
from jobs.home.home import Home
from jobs.queue.client import JobClient
from jobs.queue.job_request import JobRequest
from jobs.records.job import Job
from jobs.records.job_table import metadata
from jobs.records.keys import KeyTable, Scope
from tests.chunks import static_chunk

MODULES = Path(__file__).parent / "modules"
REPOSITORY = Path(__file__).resolve().parent.parent.parent


def poll(condition: Callable[[], bool], what: str) -> None:
    """Wait until a condition holds; the limit only turns a hang into a failure."""
    deadline = time.monotonic() + 240
    while not condition():
        assert time.monotonic() < deadline, f"waited in vain for {what}"
        time.sleep(0.02)


@pytest.fixture
def wait_until() -> Callable[[Callable[[], bool], str], None]:
    return poll


@pytest.fixture(autouse=True)
def _import_path(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let child processes import the pipeline that counts."""
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join((str(MODULES), str(REPOSITORY))))


@pytest.fixture
def write_scene() -> Callable[..., list[str]]:
    """Return the function that writes a scene folder: (folder, chunks, title) -> ids of the chunks."""
    from scene_folder import write_scene

    return write_scene


@pytest.fixture
def scene(tmp_path: Path, write_scene: Callable[..., list[str]]) -> Path:
    """Return a scene folder with the chunks ONE and TWO of scene_folder."""
    write_scene(tmp_path / "scene")
    return tmp_path / "scene"


@pytest.fixture
def store(tmp_path: Path) -> ArtifactStore:
    """Return an empty store of scenes in a folder."""
    return ArtifactStore((tmp_path / "store").as_uri())


@pytest.fixture
def pipeline() -> str:
    """Return the name of the pipeline that the home uses; a test may name another by parametrize."""
    return "counting_pipeline"


@pytest.fixture
def home(tmp_path: Path, pipeline: str) -> Home:
    return dataclasses.replace(Home.at(tmp_path / "home"), pipeline=pipeline)


@pytest.fixture
def engine(tmp_path: Path) -> Iterator[sa.Engine]:
    """The tables of a home on SQLite."""
    home = Home.at(tmp_path)
    engine = create_engine(home)
    prepare_database(home, engine, metadata)
    yield engine
    engine.dispose()


@pytest.fixture
def client(home: Home) -> Iterator[JobClient]:
    with JobClient(home) as client:
        yield client


@pytest.fixture
def submit(client: JobClient, tmp_path: Path) -> Callable[..., str]:
    """Return a function that submits a job of so many iterations that behaves in the given way."""

    def submit(iterations: int = 10, behaviour: str = "count") -> str:
        capture = tmp_path / "capture"
        capture.mkdir(exist_ok=True)
        (capture / "behaviour").write_text(behaviour)
        return client.submit(JobRequest(capture, RunConfig().changed({"train.iterations": iterations})))

    return submit


@pytest.fixture
def wait_for(client: JobClient) -> Callable[[str, Callable[[Job], bool], str], Job]:
    """Return a function that polls a job until a condition holds, and returns the job."""

    def wait_for(job_id: str, condition: Callable[[Job], bool], what: str) -> Job:
        def holds() -> bool:
            nonlocal job
            job = client.get(job_id)
            assert job is not None
            return condition(job)

        job: Job | None = None
        try:
            poll(holds, what)
        except AssertionError as error:
            raise AssertionError(f"{error}; the job is {job}") from None
        assert job is not None
        return job

    return wait_for


@pytest.fixture(scope="session")
def postgres() -> Iterator[Callable[[str], PostgresServer]]:
    """Return a function that starts a Postgres server; at the given address, if it is not empty."""
    if missing := missing_program():
        pytest.skip(missing)
    with ExitStack() as stack:

        def start(address: str) -> PostgresServer:
            folder = tempfile.TemporaryDirectory(prefix="hgs-postgres-", ignore_cleanup_errors=True)
            server = PostgresServer(Path(stack.enter_context(folder)), address)
            stack.callback(server.stop)
            server.start()
            return server

        yield start


@pytest.fixture(scope="session")
def server(postgres: Callable[[str], PostgresServer]) -> PostgresServer:
    """A Postgres server on a Unix socket."""
    return postgres("")


@pytest.fixture(scope="session")
def tcp_server(postgres: Callable[[str], PostgresServer]) -> PostgresServer:
    """A Postgres server on a TCP port of this machine."""
    return postgres("127.0.0.1")


@pytest.fixture
def port() -> int:
    """Return a TCP port that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        free: int = probe.getsockname()[1]
        return free


@pytest.fixture
def worker(home: Home) -> Iterator[Callable[..., subprocess.Popen[bytes]]]:
    """Return a function that starts a worker process on the test's home, with changes; all are killed at the end."""
    processes: list[subprocess.Popen[bytes]] = []

    def start(**changes: Any) -> subprocess.Popen[bytes]:
        environment = {**os.environ, **dataclasses.replace(home, **changes).environment()}
        command = [sys.executable, "-m", "jobs.worker"]
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, env=environment)
        processes.append(process)
        return process

    yield start
    for process in processes:
        process.kill()
        process.wait()


@pytest.fixture
def elsewhere(tmp_path: Path, pipeline: str) -> Home:
    """A home that is not there yet, at another path."""
    return dataclasses.replace(Home.at(tmp_path / "another machine" / "home"), pipeline=pipeline)


@pytest.fixture
def used(home: Home, write_scene: Callable[..., list[str]], tmp_path: Path) -> Home:
    """A home with a key, two scenes, an upload under way, and the remains of a killed process."""
    with closing(KeyTable(home)) as keys:
        keys.add("anna", {Scope.VIEW})
        keys.secret()
    store = open_store(home)
    for name, chunks in (("a", (static_chunk(b"1"), static_chunk(b"2"))), ("b", (static_chunk(b"2"),))):
        write_scene(tmp_path / name, chunks)
        store.put_scene(tmp_path / name, name)
    for name, text in (
        ("uploads/x-1f9c03ab/upload.json", "{}"),
        ("uploads/captures/room/cam 0\n\\.mp4", "video"),
        ("runs/a/checkpoint.pt", "state"),
        ("runs/a/run.lock", ""),
        ("runs/a/run.lease.3", ""),
        ("runs/a/.checkpoint.pt.1f.tmp", "half"),
        ("uploads/.deleted-1/x", "x"),
        ("live/worker-1", ""),
        ("store/chunks/" + "0" * 64, "nobody names it"),
    ):
        (home.folder / name).parent.mkdir(parents=True, exist_ok=True)
        (home.folder / name).write_text(text)
    os.utime(home.folder / "uploads/x-1f9c03ab/upload.json", (1e9, 1e9))
    return home
