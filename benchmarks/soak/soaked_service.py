"""A whole service on one machine: API, workers, a collector of chunks, Postgres and S3 behind doors that can fail."""

from __future__ import annotations

import dataclasses
import http.client
import os
import subprocess
import sys
import time
import urllib.request
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Self

from benchmarks.soak.planted_bugs import PLANTED, Bug
from benchmarks.soak.process_curves import sample_of
from benchmarks.soak.stepped_clock import SteppedClock, build_clock
from benchmarks.soak.supervised import SupervisedProcess
from hgs_core.base.own_modules import module_command
from jobs.home.home import Home
from jobs.records.keys import KeyTable, Scope
from tests.jobs.modules.flaky_proxy import FlakyProxy
from tests.jobs.modules.postgres_server import PostgresServer, free_port
from tests.jobs.modules.s3_server import S3Server

__all__ = ["Extras", "SoakedService"]

REPOSITORY = Path(__file__).resolve().parent.parent.parent
WORKERS = 2
PATIENCE = 20.0  # seconds for an answer
STARTING = 30.0  # seconds in which an API starts where the machine is not busy
DISK = 768  # MiB; a training leaves 256 free


@dataclasses.dataclass(frozen=True)
class Extras:
    """The parts of a soak that depend on the machine or on wishes."""

    bug: Bug | None = None
    old_revision: str = ""  # revision that one of the workers runs; "" for none
    small_disk: bool = False
    clocks: bool = False

    def missing(self) -> list[str]:
        """Return the reasons why something is left out."""
        return [
            *([] if self.small_disk else ["no disk is filled: mounting a small one takes root"]),
            *([] if self.clocks else ["no clock is stepped: there is no C compiler"]),
            *([] if self.old_revision else ["no worker of an earlier commit: --old-workers REVISION adds one"]),
        ]


class SoakedService:
    """The processes of a service within this context; `folder` keeps their files and logs."""

    def __init__(self, folder: Path, extras: Extras) -> None:
        """Prepare; the folder is new."""
        self.folder, self.extras = folder, extras
        self.home: Home  # the service's, behind doors that fail
        self.own_home: Home  # the same, reached directly
        self.admin_key = ""
        self.address = ""  # host and port of the API, behind a door
        self.processes: dict[str, SupervisedProcess] = {}
        self.clocks: dict[str, SteppedClock] = {}
        self.store_door: FlakyProxy
        self.database_door: FlakyProxy
        self.client_door: FlakyProxy
        self.database: PostgresServer
        self._clock_library: Path
        self._s3 = S3Server()
        self._port = free_port("127.0.0.1")
        self._stack = ExitStack()

    def __enter__(self) -> Self:
        try:
            self._start()
        except BaseException:
            self._stack.close()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        self._stack.close()

    @property
    def workers(self) -> list[SupervisedProcess]:
        """The workers, of which the last may be of an earlier commit."""
        return [process for role, process in self.processes.items() if role.startswith("worker")]

    @property
    def disk_folders(self) -> dict[str, Path]:
        """The folders that grow."""
        home = self.home.folder
        return {"runs": home / "runs", "uploads": home / "uploads", "Postgres": self.database_folder}

    def pids(self) -> dict[str, int]:
        """Return the present processes by role."""
        return {role: process.pid for role, process in self.processes.items()}

    @property
    def database_folder(self) -> Path:
        """The files of Postgres."""
        return self.folder / "postgres"

    def _start(self) -> None:
        home_folder = self.folder / "home"
        home_folder.mkdir()
        if self.extras.clocks:
            self._clock_library = build_clock(self.folder)
        if self.extras.small_disk:
            mount = ["mount", "-t", "tmpfs", "-o", f"size={DISK}m", "tmpfs", str(home_folder)]
            subprocess.run(mount, check=True)
            self._stack.callback(subprocess.run, ["umount", "--lazy", str(home_folder)], check=True)
        self.database_folder.mkdir()
        self.database = PostgresServer(self.database_folder, "127.0.0.1")
        self.database.start()
        self._stack.callback(self.database.stop)
        self._s3.start()
        self._stack.callback(self._s3.stop)
        self.store_door = self._door(int(self._s3.address.rpartition(":")[2]))
        self.database_door = self._door(self.database.port)
        self.client_door = self._door(self._port)
        self.address = f"127.0.0.1:{self.client_door.port}"
        url = self.database.new_database("hgs")
        self.own_home = dataclasses.replace(Home.at(home_folder), database_url=url, store_url="s3://bucket/soak")
        through = url.replace(str(self.database.port), str(self.database_door.port))
        self.home = dataclasses.replace(self.own_home, database_url=through)
        os.environ.update(self._s3.settings)  # the soak itself looks into the store by no door
        keys = KeyTable(self.own_home)
        self.admin_key = keys.add("admin", {Scope.ADMIN})
        keys.close()
        serve = ["serve", "--port", str(self._port), "--workers", "0", "--uploads", "free=1M,client=16", "--drain", "1"]
        self._supervise("api", module_command("server.cli", *serve))
        for number in range(WORKERS):
            self._supervise(f"worker {number + 1}", module_command("jobs.worker"))
        self._supervise("collector", module_command("benchmarks.soak.collector"))

    def _door(self, port: int) -> FlakyProxy:
        door = FlakyProxy(port)
        self._stack.callback(door.refuse)
        return door

    def _supervise(self, role: str, command: list[str]) -> None:
        path = [str(PLANTED), str(REPOSITORY)]
        environment = {**os.environ, **self.home.environment(), "AWS_ENDPOINT": self.store_door.address}
        if self.extras.bug is not None:
            environment["HGS_SOAK_BUG"] = self.extras.bug
        if self.extras.old_revision and role == f"worker {WORKERS}":
            path[1] = environment["HGS_SOAK_CHECKOUT"] = str(self._checkout())
        if self.extras.clocks:
            self.clocks[role] = SteppedClock(self._clock_library, self.folder / f"{role}.clock")
            environment |= self.clocks[role].environment
        environment["PYTHONPATH"] = os.pathsep.join(path)
        process = SupervisedProcess(role, command, environment, self.folder / f"{role.replace(' ', '-')}.log")
        self.processes[role] = process
        self._stack.callback(process.stop)

    def _checkout(self) -> Path:
        """Return a folder with the sources of the earlier commit, and our kernels if they are the same."""
        folder, revision = self.folder / "earlier", self.extras.old_revision
        git = ["git", "-C", str(REPOSITORY)]
        subprocess.run([*git, "worktree", "add", "--detach", "--quiet", str(folder), revision], check=True)
        self._stack.callback(subprocess.run, [*git, "worktree", "remove", "--force", str(folder)], check=True)
        if subprocess.run([*git, "diff", "--quiet", revision, "--", "hgs_core/native"], check=False).returncode == 0:
            for entry in sys.path:
                for library in Path(entry, "hgs_core", "native").glob("*.so"):
                    (folder / "hgs_core" / "native" / library.name).symlink_to(library)
        return folder

    def until_ready(self, seconds: float = 1800.0) -> None:
        """Wait until the API answers; on a busy machine that takes minutes, and only a hang may fail.

        Raises:
            TimeoutError: it does not.
        """
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            if self._answers("readyz"):
                return
            time.sleep(0.2)
        raise TimeoutError(f"the API does not answer; see {self.folder}/api.log")

    def at_work(self, process: SupervisedProcess) -> bool:
        """Whether a process has started: the API answers, a worker has a connection; of others nobody waits for it."""
        if process.role == "api":
            return self._answers("v1/health")
        if process not in self.workers:
            return True
        sample = sample_of(process.pid, 0.0)
        return sample is not None and sample.connections > 0

    @property
    def overdue(self) -> bool:
        """Whether the API has long been starting, as on a busy machine."""
        api = self.processes["api"]
        return time.monotonic() - api.began > STARTING and not self.at_work(api)

    def _answers(self, path: str) -> bool:
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{self._port}/{path}", timeout=PATIENCE):
                return True
        except (OSError, http.client.HTTPException):
            return False
