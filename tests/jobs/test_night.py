"""Nights of twenty jobs in which everything goes wrong, and nobody helps.

Three machines with one worker each, which a supervisor starts again when it ends, as systemd and docker compose do. One
of them does not see the captures. What jobs say is looked at while the database answers: meanwhile nobody can see it.
"""

from __future__ import annotations

import dataclasses
import os
import random
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
import sqlalchemy as sa
from flaky_proxy import FlakyProxy
from network_node import NetworkNode, why_no_nodes
from postgres_server import PostgresServer
from s3_server import S3Server, missing_program
from small_disk import small_disk

from hgs_core.runs.config import RunConfig
from jobs.artifacts import ArtifactStore
from jobs.client import JobClient
from jobs.home import Home
from jobs.job import JobState
from jobs.job_request import JobRequest
from jobs.stages import StageSeconds

OUTAGE = float(os.environ.get("HGS_NIGHT_OUTAGE", "30"))  # seconds that the store refuses, and then hangs
FULL = 0.4 * OUTAGE  # seconds that the disk is full
DATABASE_AWAY = 60.0
JOBS, ITERATIONS, CHECKPOINT_EVERY = 20, 500, 5
KILLS = ("stage",) * 10 + ("worker",) * 6 + ("both",) * 4
LINK_DROPS = int(os.environ.get("HGS_NIGHT_LINK_DROPS", "3"))
LINK_AWAY = 45.0  # seconds: longer than a worker may live without its proof of life, and others wait for it
KILLS_BESIDE = ("stage", "worker", "stage", "both", "stage") * LINK_DROPS

EVERYWHERE = "0.0.0.0"

pytestmark = [pytest.mark.slow, pytest.mark.timeout(3600)]


class Node:
    """A machine with a supervised worker."""

    def __init__(
        self, home: Home, log: Path, hidden: Path | None = None, there: tuple[NetworkNode, int] | None = None
    ) -> None:
        """Begin; `hidden` is a folder that this machine does not see, `there` its network and the port of the store."""
        worker = f"exec {sys.executable} -m jobs.worker"
        self._command = ["sh", "-c", worker]
        self._environment = {**os.environ, **home.environment()}
        if hidden is not None:
            self._command = ["unshare", "--mount", "sh", "-c", f"mount -t tmpfs none {hidden} && {worker}"]
        if there is not None:
            network, port = there
            self._command = network.there(*self._command)
            self._environment["HGS_DATABASE_URL"] = home.database_url.replace(EVERYWHERE, network.address)
            self._environment["AWS_ENDPOINT"] = f"http://{network.address}:{port}"
        self._log = log
        self._over = threading.Event()
        self.process = self._start()
        self._thread = threading.Thread(target=self._supervise)
        self._thread.start()

    def stop(self) -> None:
        self._over.set()
        self.process.kill()
        self._thread.join()
        self.process.kill()
        self.process.wait()

    def _start(self) -> subprocess.Popen[bytes]:
        with self._log.open("ab") as log:
            return subprocess.Popen(
                self._command, env=self._environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log
            )

    def _supervise(self) -> None:
        while not self._over.is_set():
            self.process.wait()
            if not self._over.wait(1.0):
                self.process = self._start()


class Watch:
    """Looks twice a second which jobs say that they run, and whether there is a process that does it."""

    def __init__(self, client: JobClient) -> None:
        self.longest = 0.0  # seconds that a job said `running` without a process
        self._client = client
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._watch)
        self._thread.start()

    def stop(self) -> None:
        self._over.set()
        self._thread.join()

    def _watch(self) -> None:
        alone: dict[str, float] = {}  # job -> seconds
        before = time.monotonic()
        while not self._over.wait(0.5):
            try:
                running = {job.id for job in self._client.list(1000, JobState.RUNNING)}
            except sa.exc.DBAPIError:
                before = time.monotonic()
                continue
            now = time.monotonic()
            attended = {run.name for _, run in stages(self._client.home)}
            alone = {job: alone.get(job, 0.0) + now - before for job in running - attended}
            self.longest = max(self.longest, *alone.values(), 0.0)
            before = now


def stages(home: Home) -> list[tuple[int, Path]]:
    """Return the processes of stages on this machine and the run of each."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes().decode().split("\0")
        except OSError:
            continue
        if "jobs.stage" in words and Path(words[-2]).parent == home.runs:
            found.append((int(process.name), Path(words[-2])))
    return found


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    with small_disk(tmp_path / "disk", megabytes=48) as folder:
        yield folder


@pytest.fixture
def store(monkeypatch: pytest.MonkeyPatch) -> Iterator[FlakyProxy]:
    if missing := missing_program():
        pytest.skip(missing)
    server = S3Server()
    server.start()
    proxy = FlakyProxy(int(server.address.rpartition(":")[2]), EVERYWHERE)
    for name, value in {**server.settings, "AWS_ENDPOINT": proxy.address}.items():
        monkeypatch.setenv(name, value)
    yield proxy
    proxy.refuse()
    server.stop()


@pytest.fixture
def home(disk: Path, store: FlakyProxy, server: PostgresServer) -> Home:
    return dataclasses.replace(
        Home.at(disk / "home"),
        pipeline="counting_pipeline",
        database_url=server.new_database(),
        store_url="s3://bucket/night",
        stage_silence=StageSeconds(20.0),
    )


@pytest.fixture
def nodes(home: Home, client: JobClient, tmp_path: Path) -> Iterator[list[Node]]:
    captures = tmp_path / "captures"
    captures.mkdir()
    nodes = [Node(home, tmp_path / f"{number}.log", captures if number == 2 else None) for number in range(3)]
    yield nodes
    for node in nodes:
        node.stop()


class Killer(threading.Thread):
    """Kills stages, workers and both with -9, one after the other, while jobs run and the database answers."""

    def __init__(self, home: Home, nodes: list[Node], kills: tuple[str, ...]) -> None:
        super().__init__()
        self._kills = kills
        self.killed: list[str] = []
        self.pause = threading.Event()
        self.over = threading.Event()
        self._home, self._nodes = home, nodes

    def run(self) -> None:
        dice = random.Random(7)
        for kind in dice.sample(self._kills, len(self._kills)):
            if self.over.wait(dice.uniform(4.0, 10.0)):
                return
            while self.pause.is_set() or not (found := stages(self._home)):
                if self.over.wait(0.2):
                    return
            victims = [dice.choice(found)[0]] if kind != "worker" else []
            if kind != "stage":
                victims.append(dice.choice(self._nodes).process.pid)
            for pid in victims:
                try:
                    os.kill(pid, signal.SIGKILL)
                except ProcessLookupError:
                    continue
            self.killed.append(kind)


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
    watch, killer = Watch(client), Killer(client.home, nodes[:2], KILLS)
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
    )  # docs/jobs.md quotes it
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
        watch, killer = Watch(client), Killer(client.home, nodes, KILLS_BESIDE)
        killer.start()
        try:
            for drop in range(LINK_DROPS):
                time.sleep(15)
                networks[drop % 3].pull_the_cable()
                time.sleep(LINK_AWAY)
                networks[drop % 3].plug_it_in()
            wait_for_the_end(client)
        finally:
            killer.over.set()
            killer.join()
            watch.stop()
        print(
            f"{client.counts()['succeeded']} of {JOBS} succeeded after {time.monotonic() - began:.0f} s: {LINK_DROPS} "
            f"links dropped for {LINK_AWAY:g} s, {len(killer.killed)} kills; longest `running` without a process "
            f"{watch.longest:.0f} s"
        )  # docs/jobs.md quotes it
        check(client, job_ids)
        assert len(killer.killed) == len(KILLS_BESIDE), "the night was too short for all kills"


def submit(client: JobClient, captures: Path, iterations: int = ITERATIONS, hangs: int = -1) -> list[str]:
    """Submit the jobs of a night, of which one may hang once."""
    config = RunConfig().changed({"train.iterations": iterations})
    job_ids = []
    for number in range(JOBS):
        capture = captures / f"take-{number:02}"
        capture.mkdir()
        (capture / "behaviour").write_text("hang once" if number == hangs else "count")
        job_ids.append(client.submit(JobRequest(capture, config)))
    return job_ids


def wait_for_the_end(client: JobClient) -> None:
    deadline = time.monotonic() + 2400
    while client.counts()["succeeded"] + client.counts()["failed"] < JOBS:
        time.sleep(0.5)
        assert time.monotonic() < deadline, (client.counts(), [job.waiting for job in client.list(JOBS)])


def check(client: JobClient, job_ids: list[str]) -> None:
    """Require that all succeeded, each is published, and none repeated more than a checkpoint's interval."""
    jobs = [job for job_id in job_ids if (job := client.get(job_id))]
    assert [job.error for job in jobs if job.error] == []
    assert [job.state for job in jobs] == [JobState.SUCCEEDED] * JOBS
    scenes = [scene.id for scene in ArtifactStore(client.home.store_url).list_scenes()]
    assert sorted(scenes) == sorted(job_ids)
    assert max(most_repeated(client.home.run(job_id)) for job_id in job_ids) <= CHECKPOINT_EVERY


def fill(ballast: Path, seconds: float) -> None:
    """Keep a disk full for so long, whatever is given back."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        with ballast.open("ab", buffering=0) as file:
            try:
                while True:
                    file.write(bytes(4096))
            except OSError:
                time.sleep(0.2)
    ballast.unlink()


def most_repeated(run: Path) -> int:
    """Return how many iterations a process repeated at most that another had made; none may go back further."""
    reached, most, last = 0, 0, ""
    finished: set[str] = set()
    for line in (run / "iterations.log").read_text().splitlines():
        words = line.split()
        if len(words) != 2:  # torn by the full disk
            continue
        pid, iteration = words[0], int(words[1])
        if pid != last:
            assert pid not in finished, "two processes trained at once"
            finished.add(last)
            most, last = max(most, reached - iteration), pid
        reached = max(reached, iteration + 1)
    return most
