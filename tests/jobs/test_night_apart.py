"""A night of three machines that share nothing but Postgres and an object store, each behind a cable of its own.

Workers and stages are killed and cables pulled, and nobody helps. Every iteration of a training hashes the one before,
so that a scene whose training lost or mixed anything has other bits.
"""

from __future__ import annotations

import dataclasses
import hashlib
import os
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from chain_pipeline import SECONDS_PER_ITERATION, chain
from flaky_proxy import FlakyProxy
from network_node import NetworkNode, why_no_nodes
from night import (
    EVERYWHERE,
    ITERATIONS,
    JOBS,
    LINK_AWAY,
    Killer,
    Node,
    Watch,
    drop_links,
    flaky_store,
    most_repeated,
    submit,
    wait_for_the_end,
)
from postgres_server import PostgresServer

from jobs.artifacts.artifact_store import ArtifactStore
from jobs.home.home import Home
from jobs.queue.client import JobClient
from jobs.records.job import JobState

LINK_DROPS = int(os.environ.get("HGS_NIGHT_LINK_DROPS", "3"))
KILLS = ("stage", "worker", "stage", "both", "worker") * LINK_DROPS

pytestmark = [pytest.mark.slow, pytest.mark.timeout(3600)]


@pytest.fixture
def networks() -> Iterator[list[NetworkNode]]:
    if reason := why_no_nodes():
        pytest.skip(reason)
    with ExitStack() as stack:
        yield [stack.enter_context(NetworkNode()) for _ in range(3)]


@pytest.fixture
def server(networks: list[NetworkNode], postgres: Callable[[str], PostgresServer]) -> Iterator[PostgresServer]:
    server = postgres(EVERYWHERE)
    yield server
    server.stop()


@pytest.fixture
def store(monkeypatch: pytest.MonkeyPatch) -> Iterator[FlakyProxy]:
    with flaky_store(monkeypatch) as proxy:
        yield proxy


@pytest.fixture
def home(tmp_path: Path, store: FlakyProxy, server: PostgresServer) -> Home:
    """That of the machine that submits."""
    return dataclasses.replace(
        Home.at(tmp_path / "homes" / "api"),
        pipeline="chain_pipeline",
        database_url=server.new_database(),
        store_url="s3://bucket/night",
        run_state="store",
    )


@pytest.fixture
def nodes(
    home: Home, client: JobClient, tmp_path: Path, networks: list[NetworkNode], store: FlakyProxy
) -> Iterator[list[Node]]:
    """Each sees a home of its own, and of those of others nothing."""
    (tmp_path / "captures").mkdir()
    homes = [dataclasses.replace(home, folder=home.folder.parent / str(number)) for number in range(3)]
    for own in homes:
        own.folder.mkdir()
    nodes = []
    for own, network in zip(homes, networks, strict=True):
        hidden = [other.folder for other in (home, *homes) if other != own]
        nodes.append(Node(own, tmp_path / f"{own.folder.name}.log", hidden, (network, store.port)))
    yield nodes
    for node in nodes:
        node.stop()


def test_nothing_shared_and_nothing_lost(
    client: JobClient, nodes: list[Node], networks: list[NetworkNode], tmp_path: Path
) -> None:
    iterations = ITERATIONS * LINK_DROPS // 3  # enough for the whole night
    job_ids = submit(client, tmp_path / "captures", iterations)
    began = time.monotonic()
    watch, killer = Watch(client, nodes), Killer(nodes, nodes, KILLS)
    killer.start()
    try:
        drop_links(networks, LINK_DROPS)
        wait_for_the_end(client)
    finally:
        killer.over.set()
        killer.join()
        watch.stop()
    took = time.monotonic() - began
    jobs = [job for job_id in job_ids if (job := client.get(job_id))]
    logs = [Path(job.capture) / f"{job.id}.log" for job in jobs]
    repeated = max(most_repeated(log) for log in logs if log.exists())
    places = sum(len({line.split()[0] for line in log.read_text().splitlines()}) for log in logs)
    print(
        f"{client.counts()['succeeded']} of {JOBS} succeeded after {took:.0f} s: {LINK_DROPS} links dropped for "
        f"{LINK_AWAY:g} s, {len(killer.killed)} kills, {places} processes trained; longest `running` without a process "
        f"{watch.longest:.0f} s; most repeated {repeated * SECONDS_PER_ITERATION:.1f} s of training"
    )
    assert [job.error for job in jobs if job.error] == []
    assert [job.state for job in jobs] == [JobState.SUCCEEDED] * JOBS
    artifacts = ArtifactStore(client.home.store_url)
    assert sorted(scene.id for scene in artifacts.list_scenes()) == sorted(job_ids)
    undisturbed = hashlib.sha256(chain(iterations)).hexdigest()
    assert [chunk.id for chunk in artifacts.list_chunks()] == [undisturbed]  # the same for every scene
    assert len(killer.killed) == len(KILLS), "the night was too short for all kills"
