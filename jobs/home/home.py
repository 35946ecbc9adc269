"""Where one installation of the service keeps its database, its runs and its published scenes."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from hgs_core.base.errors import InputError
from jobs.home.byte_sizes import bytes_of
from jobs.home.stage_limits import StageLimits

__all__ = ["Home"]

RUN_STATES = ("home", "store")


@dataclass(frozen=True)
class Home:
    """The places that the API process, the workers and their stages agree on.

    `folder` holds the runs and the locks. On several machines it is a shared folder, or, where the state of runs lies
    in the store, each machine's own.
    """

    folder: Path
    database_url: str  # sqlite:///FILE or postgresql://USER:PASSWORD@HOST/DATABASE
    store_url: str  # a folder as file:///FOLDER, or s3://BUCKET/PREFIX
    pipeline: str = "hgs_core.runs.stages"  # the module that gives create_run, initialise, train and encode
    limits: StageLimits = field(default_factory=StageLimits)
    capture_cache: float = 100e9  # bytes that copies of uploaded captures may take, where runs lie in the store
    run_state: str = "home"  # place of the state of runs: "home" or "store"

    def __post_init__(self) -> None:
        """Refuse settings that cannot work.

        Raises:
            InputError: the state of runs is to lie in a folder's store, or beside a database that others cannot reach.
        """
        if self.run_state not in RUN_STATES:
            raise InputError("HGS_RUN_STATE", f"{self.run_state!r} is not one of {', '.join(RUN_STATES)}")
        if self.run_state == "store":
            if self.store_url.startswith("file://"):
                cure = "give HGS_STORE_URL=s3://BUCKET/PREFIX, or leave the state of runs in the home"
                raise InputError("HGS_RUN_STATE", "store takes an object store, and the store is a folder", cure)
            if self.database_url.startswith("sqlite"):
                cure = "give HGS_DATABASE_URL=postgresql://…, or leave the state of runs in the home"
                raise InputError("HGS_RUN_STATE", "store takes Postgres: SQLite is of one machine", cure)

    @classmethod
    def at(cls, folder: Path) -> Home:
        """Return the home that keeps everything in `folder`."""
        folder = folder.expanduser().resolve()
        return cls(folder, f"sqlite:///{folder / 'jobs.sqlite'}", (folder / "store").as_uri())

    @classmethod
    def from_environment(cls, environment: Mapping[str, str] = os.environ) -> Home:
        """Read `HGS_HOME` (default ~/.hgs), `HGS_DATABASE_URL`, `HGS_STORE_URL`, `HGS_PIPELINE`, `HGS_RUN_STATE`,
        `HGS_CAPTURE_CACHE` (bytes) and the limits of stages.

        An empty variable counts as absent. A store given as a plain path becomes a file URL.

        Raises:
            InputError: a limit is not a positive number, or names an unknown stage; or the state of runs cannot lie
                where it shall.
        """
        default = cls.at(Path(environment.get("HGS_HOME") or "~/.hgs"))
        store_url = environment.get("HGS_STORE_URL") or default.store_url
        if "://" not in store_url:
            store_url = Path(store_url).expanduser().resolve().as_uri()
        cache = environment.get("HGS_CAPTURE_CACHE")
        return cls(
            default.folder,
            environment.get("HGS_DATABASE_URL") or default.database_url,
            store_url,
            environment.get("HGS_PIPELINE") or default.pipeline,
            StageLimits.from_environment(environment),
            bytes_of(cache, "HGS_CAPTURE_CACHE") if cache else default.capture_cache,
            environment.get("HGS_RUN_STATE") or default.run_state,
        )

    def environment(self) -> dict[str, str]:
        """Return the variables from which a child process reads this home again."""
        return {
            "HGS_HOME": str(self.folder),
            "HGS_DATABASE_URL": self.database_url,
            "HGS_STORE_URL": self.store_url,
            "HGS_PIPELINE": self.pipeline,
            **self.limits.environment(),
            "HGS_CAPTURE_CACHE": repr(self.capture_cache),
            "HGS_RUN_STATE": self.run_state,
        }

    @property
    def runs_in_store(self) -> bool:
        """Whether the state of runs lies in the store, and machines share no folder."""
        return self.run_state == "store"

    @property
    def runs(self) -> Path:
        """The folder of the run folders."""
        return self.folder / "runs"

    def run(self, job_id: str) -> Path:
        """Return the run folder of a job."""
        return self.runs / job_id
