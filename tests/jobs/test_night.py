"""Nights of twenty jobs in which everything goes wrong, and nobody helps.

Three machines with one worker each, which a supervisor starts again when it ends, as systemd and docker compose do. One
of them does not see the captures. What jobs say is looked at while the database answers: meanwhile nobody can see it.
"""

from __future__ import annotations

import dataclasses
import os
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from flaky_proxy import FlakyProxy
from network_node import NetworkNode, why_no_nodes
from night import (
    CHECKPOINT_EVERY,
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
from small_disk import small_disk

from jobs.artifacts.artifact_store import ArtifactStore
from jobs.home.home import Home
from jobs.home.stage_limits import StageLimits
from jobs.home.stage_settings import StageSeconds
from jobs.queue.client import JobClient
from jobs.records.job import JobState

OUTAGE = float(os.environ.get("HGS_NIGHT_OUTAGE", "30"))  # seconds that the store refuses, and then hangs
FULL = 0.4 * OUTAGE  # seconds that the disk is full
DATABASE_AWAY = 60.0
KILLS = ("stage",) * 10 + ("worker",) * 6 + ("both",) * 4
LINK_DROPS = int(os.environ.get("HGS_NIGHT_LINK_DROPS", "3"))
KILLS_BESIDE = ("stage", "worker", "stage", "both", "stage") * LINK_DROPS

pytestmark = [pytest.mark.slow, pytest.mark.timeout(3600)]


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    with small_disk(tmp_path / "disk", megabytes=48) as folder:
        yield folder


@pytest.fixture
def store(monkeypatch: pytest.MonkeyPatch) -> Iterator[FlakyProxy]:
    with flaky_store(monkeypatch) as proxy:
        yield proxy


@pytest.fixture
def home(disk: Path, store: FlakyProxy, server: PostgresServer) -> Home:
    return dataclasses.replace(
        Home.at(disk / "home"),
        pipeline="counting_pipeline",
        database_url=server.new_database(),
        store_url="s3://bucket/night",
        limits=StageLimits(StageSeconds(20.0)),
    )


@pytest.fixture
def nodes(home: Home, client: JobClient, tmp_path: Path) -> Iterator[list[Node]]:
    captures = tmp_path / "captures"
    captures.mkdir()
    nodes = [Node(home, tmp_path / f"{number}.log", [captures] if number == 2 else ()) for number in range(3)]
    yield nodes
    for node in nodes:
        node.stop()


def test_twenty_of_twenty_succeed(
    client: JobClient,
    nodes: list[Node],
    server: PostgresServer,
    store: FlakyProxy,
    disk: Path,
    tmp_path: Path,
) -> None:
    job_ids = submit(client, tmp_path / "captures", hangs=3)
    began = time.monotonic()
    watch, killer = Watch(client, nodes), Killer(nodes, nodes[:2], KILLS)
    killer.start()
    try:
        time.sleep(10)
        store.refuse()
        time.sleep(OUTAGE)
        store.pass_on()
        time.sleep(20)
        store.hang()
        time.sleep(OUTAGE)
        store.pass_on()
        time.sleep(20)
        fill(disk / "ballast", FULL)
        time.sleep(20)
        killer.pause.set()
        server.stop()
        time.sleep(DATABASE_AWAY)
        server.start()
        killer.pause.clear()
        wait_for_the_end(client)
    finally:
        killer.over.set()
        killer.join()
        watch.stop()

    print(
        f"{client.counts()['succeeded']} of {JOBS} succeeded after {time.monotonic() - began:.0f} s: store away "
        f"{OUTAGE:g} s refusing and {OUTAGE:g} s hanging, disk full {FULL:g} s, Postgres away {DATABASE_AWAY:g} s, one "
        f"stage hung, one node without captures, {len(killer.killed)} kills; longest `running` without a process "
        f"{watch.longest:.0f} s"
    )
    check(client, job_ids)
    assert len(killer.killed) == len(KILLS), "the night was too short for all kills"


@pytest.fixture
def networks() -> Iterator[list[NetworkNode]]:
    if reason := why_no_nodes():
        pytest.skip(reason)
    with ExitStack() as stack:
        yield [stack.enter_context(NetworkNode()) for _ in range(3)]


class TestDroppedLinks:
    """Three machines, each with a cable of its own that is pulled and plugged in again; the home is a shared folder."""

    @pytest.fixture
    def server(
        self, networks: list[NetworkNode], postgres: Callable[[str], PostgresServer]
    ) -> Iterator[PostgresServer]:
        server = postgres(EVERYWHERE)
        yield server
        server.stop()

    @pytest.fixture
    def nodes(
        self, home: Home, client: JobClient, tmp_path: Path, networks: list[NetworkNode], store: FlakyProxy
    ) -> Iterator[list[Node]]:
        (tmp_path / "captures").mkdir()
        nodes = [
            Node(home, tmp_path / f"{number}.log", there=(network, store.port))
            for number, network in enumerate(networks)
        ]
        yield nodes
        for node in nodes:
            node.stop()

    def test_none_is_lost(
        self, client: JobClient, nodes: list[Node], networks: list[NetworkNode], tmp_path: Path
    ) -> None:
        job_ids = submit(client, tmp_path / "captures", ITERATIONS * LINK_DROPS // 3)  # enough for the whole night
        began = time.monotonic()
        watch, killer = Watch(client, nodes), Killer(nodes, nodes, KILLS_BESIDE)
        killer.start()
        try:
            drop_links(networks, LINK_DROPS)
            wait_for_the_end(client)
        finally:
            killer.over.set()
            killer.join()
            watch.stop()
        print(
            f"{client.counts()['succeeded']} of {JOBS} succeeded after {time.monotonic() - began:.0f} s: {LINK_DROPS} "
            f"links dropped for {LINK_AWAY:g} s, {len(killer.killed)} kills; longest `running` without a process "
            f"{watch.longest:.0f} s"
        )
        check(client, job_ids)
        assert len(killer.killed) == len(KILLS_BESIDE), "the night was too short for all kills"


def check(client: JobClient, job_ids: list[str]) -> None:
    """Require that all succeeded, each is published, and none repeated more than a checkpoint's interval."""
    jobs = [job for job_id in job_ids if (job := client.get(job_id))]
    assert [job.error for job in jobs if job.error] == []
    assert [job.state for job in jobs] == [JobState.SUCCEEDED] * JOBS
    scenes = [scene.id for scene in ArtifactStore(client.home.store_url).list_scenes()]
    assert sorted(scenes) == sorted(job_ids)
    assert max(most_repeated(client.home.run(job_id) / "iterations.log") for job_id in job_ids) <= CHECKPOINT_EVERY


def fill(ballast: Path, seconds: float) -> None:
    """Keep a disk full for so long, even as space is freed."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        with ballast.open("ab", buffering=0) as file:
            try:
                while True:
                    file.write(bytes(4096))
            except OSError:
                time.sleep(0.2)
    ballast.unlink()
