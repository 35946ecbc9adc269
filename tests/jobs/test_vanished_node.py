"""A machine that vanishes without a word: its cable is pulled, and nobody says goodbye, whether it dies then or not."""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from network_node import NetworkNode, why_no_nodes
from postgres_server import PostgresServer

from jobs.home.database import connection_url
from jobs.home.home import Home
from jobs.queue.client import JobClient
from jobs.queue.liveness import PostgresLiveness
from jobs.records.job import Job
from jobs.worker import FENCED

Worker = subprocess.Popen[bytes]
WaitFor = Callable[[str, Callable[[Job], bool], str], Job]
Poll = Callable[[Callable[[], bool], str], None]

HOLD = """
import signal
from jobs.home.database import connection_url
from jobs.home.home import Home
from jobs.queue.liveness import PostgresLiveness
home = Home.from_environment()
PostgresLiveness(connection_url(home)).hold("node", lambda: None)
print("holds", flush=True)
signal.pause()
"""


@pytest.fixture
def node() -> Iterator[NetworkNode]:
    if reason := why_no_nodes():
        pytest.skip(reason)
    with NetworkNode() as node:
        yield node


@pytest.fixture
def server(node: NetworkNode, postgres: Callable[[str], PostgresServer]) -> Iterator[PostgresServer]:
    server = postgres(node.address)
    yield server
    server.stop()


@pytest.fixture
def home(tmp_path: Path, pipeline: str, server: PostgresServer) -> Home:
    local = Home.at(tmp_path / "home")
    return dataclasses.replace(local, pipeline=pipeline, database_url=server.new_database())


@pytest.fixture
def start_on_node(node: NetworkNode, home: Home) -> Iterator[Callable[..., Worker]]:
    """Return a function that starts a Python program on the node."""
    processes: list[Worker] = []

    def start(*arguments: str) -> Worker:
        processes.append(node.start(sys.executable, *arguments, env={**os.environ, **home.environment()}))
        return processes[-1]

    yield start
    for process in processes:
        process.kill()
        process.communicate()


@pytest.mark.slow
def test_the_server_lets_go_of_its_lock(
    node: NetworkNode, home: Home, start_on_node: Callable[..., Worker], wait_until: Poll
) -> None:
    process = start_on_node("-c", HOLD)
    assert process.stdout is not None
    assert process.stdout.readline() == b"holds\n"
    observer = PostgresLiveness(connection_url(home), grace=0.0)

    def is_dead() -> bool:
        with observer.claim_dead("node") as dead:
            return dead

    assert not is_dead()
    node.pull_the_cable()
    process.kill()
    process.wait()
    assert not is_dead()  # the server has not heard of it
    wait_until(is_dead, "the server to notice")


@pytest.mark.slow
@pytest.mark.parametrize("dies", [True, False])
def test_its_job_is_taken_over(
    node: NetworkNode,
    client: JobClient,
    submit: Callable[..., str],
    start_on_node: Callable[..., Worker],
    worker: Callable[[], Worker],
    wait_for: WaitFor,
    wait_until: Poll,
    dies: bool,
) -> None:
    job_id = submit(iterations=4000)
    process = start_on_node("-m", "jobs.worker")
    wait_for(job_id, lambda job: job.stage == "train" and job.done > 0, "training")
    worker()
    node.pull_the_cable()
    pulled = time.monotonic()
    if dies:
        process.kill()
    status = process.wait()
    assert dies or status == FENCED  # it ends by itself, before another may go on
    run = client.home.run(job_id)
    wait_until(lambda: len({pid for pid, _ in iterations(run)}) == 2, "another worker")
    print(f"taken over after {time.monotonic() - pulled:.0f} s")  # docs/jobs.md quotes it
    trained = [done for _, done in iterations(run)]
    assert len(trained) - len(set(trained)) < 5  # a checkpoint's interval
    assert wait_for(job_id, lambda job: True, "the job").attempt == 1


def iterations(run: Path) -> list[list[str]]:
    return [line.split() for line in (run / "iterations.log").read_text().splitlines()]
