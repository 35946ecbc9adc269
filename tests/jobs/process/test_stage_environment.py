"""The part of a worker's environment that a stage receives."""

from __future__ import annotations

import asyncio
import dataclasses
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from hgs_core.base.progress import Progress, silent
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder, RunSpec
from jobs import stage, worker
from jobs.home.home import Home
from jobs.home.stage_settings import HELP, SHOW
from jobs.process.stage_environment import stage_environment, without_secrets
from jobs.process.stage_outcome import Done
from jobs.process.stage_runner import StageRunner
from server.cli import main as command_line

SECRETS = {
    "AWS_SECRET_ACCESS_KEY": "a",
    "AZURE_STORAGE_KEY": "b",
    "GOOGLE_SERVICE_ACCOUNT": "c",
    "PGPASSWORD": "d",
    "HGS_DATABASE_URL": "postgresql://e",
    "HGS_STORE_URL": "s3://f",
    "HGS_WEBHOOK_SECRET": "g",
    "HGS_KEY": "h",
}
PLAIN = {"PATH": "/bin", "HGS_THREADS": "2", "CUDA_VISIBLE_DEVICES": "1"}


@pytest.fixture
def run(tmp_path: Path) -> Callable[[bool], Path]:
    def run(by_segment: bool) -> Path:
        folder = RunFolder(tmp_path / "run")
        folder.path.mkdir()
        config = RunConfig().changed({"encode.by_segment": by_segment})
        folder.write_spec(RunSpec(tmp_path, "fingerprint", config))
        return folder.path

    return run


def test_what_gives_access_is_left_out_and_all_else_stays() -> None:
    assert without_secrets(SECRETS | PLAIN) == PLAIN


@pytest.fixture
def apart(home: Home) -> Home:
    """A home of machines that share no folder."""
    urls = {"store_url": "s3://bucket/hgs", "database_url": "postgresql://db/hgs"}
    return dataclasses.replace(home, run_state="store", **urls)


@pytest.mark.parametrize(
    ("stage", "by_segment"),
    [("initialise", False), ("train", False), ("train", True), ("encode", False), (HELP, True)],
)
def test_what_decodes_videos_has_no_secrets(
    home: Home, run: Callable[[bool], Path], stage: str, by_segment: bool
) -> None:
    told = stage_environment(home, stage, run(by_segment), SECRETS | PLAIN)
    assert not SECRETS.keys() & told.keys()
    assert told.items() >= PLAIN.items()
    assert Home.from_environment(told).folder == home.folder
    assert Home.from_environment(told).pipeline == home.pipeline


@pytest.mark.parametrize("stage", ["publish", SHOW])
def test_what_publishes_reads_the_home_that_the_worker_has(home: Home, run: Callable[[bool], Path], stage: str) -> None:
    told = stage_environment(home, stage, run(False), SECRETS | PLAIN)
    assert Home.from_environment(told) == home
    assert told["AWS_SECRET_ACCESS_KEY"] == "a"


@pytest.mark.parametrize(("stage", "by_segment"), [(HELP, True), ("train", True)])
def test_what_exchanges_segments_through_the_store_reads_it_too(
    apart: Home, run: Callable[[bool], Path], stage: str, by_segment: bool
) -> None:
    told = stage_environment(apart, stage, run(by_segment), SECRETS | PLAIN)
    assert Home.from_environment(told) == apart
    assert told["AWS_SECRET_ACCESS_KEY"] == "a"


def test_a_run_that_says_nothing_of_segments_may_exchange_them(apart: Home, tmp_path: Path) -> None:
    (tmp_path / "run.json").write_text(json.dumps({"iterations": 3}))
    assert stage_environment(apart, "train", tmp_path, SECRETS)["AWS_SECRET_ACCESS_KEY"] == "a"
    assert "AWS_SECRET_ACCESS_KEY" not in stage_environment(apart, "encode", tmp_path, SECRETS)


@pytest.mark.skipif(sys.platform != "linux", reason="no other system knows it")
def test_a_process_keeps_its_secrets_to_itself() -> None:
    dumpable = "import ctypes\ndumpable = lambda: ctypes.CDLL(None).prctl(3, 0, 0, 0, 0)\n"  # PR_GET_DUMPABLE
    program = (
        "from jobs.process.stage_environment import keep_secrets as keep\nprint(dumpable()); keep(); print(dumpable())"
    )
    assert subprocess.check_output([sys.executable, "-c", dumpable + program], text=True).split() == ["1", "0"]


@pytest.mark.parametrize("keeper", ["worker", "server", "publisher"])
def test_who_has_secrets_keeps_them(home: Home, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, keeper: str) -> None:
    class Kept(Exception): ...  # noqa: N818

    def keep() -> None:
        raise Kept

    monkeypatch.setattr(worker, "keep_secrets", keep)
    monkeypatch.setattr(stage, "keep_secrets", keep)
    monkeypatch.setattr("jobs.process.stage_environment.keep_secrets", keep)
    begin = {
        "worker": lambda: worker.run_worker(home),
        "server": lambda: command_line(["serve"]),
        "publisher": lambda: stage._run(SHOW, tmp_path, home, silent, lambda: None, lambda: None),
    }[keeper]
    with pytest.raises(Kept):
        begin()


def test_the_process_of_a_stage_has_no_secrets(home: Home, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "telling.py").write_text(
        "import os\ndef encode(run, progress):\n    (run / 'told').write_text(' '.join(os.environ))\n"
    )
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "a")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)

    async def nothing(progress: Progress) -> None: ...

    runner = StageRunner(dataclasses.replace(home, pipeline="telling"))
    assert asyncio.run(runner.run("workflow", "encode", tmp_path, nothing)) == Done()
    told = (tmp_path / "told").read_text().split()
    assert "HGS_HOME" in told
    assert not {"AWS_SECRET_ACCESS_KEY", "HGS_DATABASE_URL"} & set(told)
