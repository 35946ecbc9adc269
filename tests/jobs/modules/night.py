"""The cast of a night of faults: supervised workers, a watch over jobs, and a killer."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pytest
import sqlalchemy as sa
from flaky_proxy import FlakyProxy
from network_node import NetworkNode
from s3_server import running_s3_server

from hgs_core.runs.run_config import RunConfig
from jobs.home.home import Home
from jobs.queue.client import JobClient
from jobs.queue.job_request import JobRequest
from jobs.records.job import JobState

EVERYWHERE = "0.0.0.0"
JOBS, ITERATIONS, CHECKPOINT_EVERY = 20, 500, 5
LINK_AWAY = 45.0  # seconds: longer than a worker may live without its proof of life, and others wait for it


@contextmanager
def flaky_store(monkeypatch: pytest.MonkeyPatch) -> Iterator[FlakyProxy]:
    """Start an S3 store and go to it by a proxy that can stand in the way; skip the test where there is none."""
    with running_s3_server() as server:
        proxy = FlakyProxy(int(server.address.rpartition(":")[2]), EVERYWHERE)
        for name, value in {**server.settings, "AWS_ENDPOINT": proxy.address}.items():
            monkeypatch.setenv(name, value)
        try:
            yield proxy
        finally:
            proxy.refuse()


class Node:
    """A machine with a supervised worker."""

    def __init__(
        self, home: Home, log: Path, hidden: Sequence[Path] = (), there: tuple[NetworkNode, int] | None = None
    ) -> None:
        """Begin; `hidden` are folders that this machine does not see, `there` its network and the port of the store."""
        self.home = home
        worker = f"exec {sys.executable} -m jobs.worker"
        self._command = ["sh", "-c", worker]
        self._environment = {**os.environ, **home.environment()}
        if hidden:
            mounts = "".join(f"mount -t tmpfs none {folder} && " for folder in hidden)
            self._command = ["unshare", "--mount", "sh", "-c", mounts + worker]
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

    def __init__(self, client: JobClient, nodes: Sequence[Node]) -> None:
        self.longest = 0.0  # seconds that a job said `running` without a process
        self._client = client
        self._homes = [node.home for node in nodes]
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
            attended = {run.name for _, run in stages(self._homes)}
            alone = {job: alone.get(job, 0.0) + now - before for job in running - attended}
            self.longest = max(self.longest, *alone.values(), 0.0)
            before = now


def stages(homes: Sequence[Home]) -> list[tuple[int, Path]]:
    """Return the processes of stages on this machine and the run of each."""
    runs, found = {home.runs for home in homes}, []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes().decode().split("\0")
        except OSError:
            continue
        if "jobs.stage" in words and Path(words[-2]).parent in runs:
            found.append((int(process.name), Path(words[-2])))
    return found


class Killer(threading.Thread):
    """Kills stages, workers and both with -9, one after the other, while jobs run and the database answers."""

    def __init__(self, nodes: Sequence[Node], victims: Sequence[Node], kills: Sequence[str]) -> None:
        """Kill stages of all `nodes`, and the workers of those that are `victims`."""
        super().__init__()
        self._kills = kills
        self.killed: list[str] = []
        self.pause = threading.Event()
        self.over = threading.Event()
        self._homes, self._nodes = [node.home for node in nodes], victims

    def run(self) -> None:
        dice = random.Random(7)
        for kind in dice.sample(self._kills, len(self._kills)):
            if self.over.wait(dice.uniform(4.0, 10.0)):
                return
            while self.pause.is_set() or not (found := stages(self._homes)):
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


def drop_links(networks: Sequence[NetworkNode], drops: int, pause: float = 15.0) -> None:
    """Pull one cable after the other and plug it in again."""
    for drop in range(drops):
        time.sleep(pause)
        networks[drop % len(networks)].pull_the_cable()
        time.sleep(LINK_AWAY)
        networks[drop % len(networks)].plug_it_in()


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


def most_repeated(log: Path) -> int:
    """Return how many iterations a process repeated at most that another had made; none may go back further."""
    reached, most, last = 0, 0, ""
    finished: set[str] = set()
    for line in log.read_text().splitlines():
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
