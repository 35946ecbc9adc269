"""What a stage learns of its worker's environment."""

from __future__ import annotations

import asyncio
import dataclasses
import json
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from hgs_core.base.progress import Progress
from hgs_core.runs.config import RunConfig
from hgs_core.runs.folder import RunFolder, RunSpec
from jobs.home import Home
from jobs.stage_environment import stage_environment, without_secrets
from jobs.stages import HELP
from jobs.subprocesses import StageRunner

SECRETS = {
    "AWS_SECRET_ACCESS_KEY": "a", "AZURE_STORAGE_KEY": "b", "GOOGLE_SERVICE_ACCOUNT": "c", "PGPASSWORD": "d",
    "HGS_DATABASE_URL": "postgresql://e", "HGS_STORE_URL": "s3://f", "HGS_WEBHOOK_SECRET": "g", "HGS_KEY": "h",
}  # fmt: skip
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


@pytest.mark.parametrize("stage", ["initialise", "train", "encode"])
def test_what_decodes_videos_has_no_secrets(home: Home, run: Callable[[bool], Path], stage: str) -> None:
    told = stage_environment(home, stage, run(False), SECRETS | PLAIN)
    assert not SECRETS.keys() & told.keys()
    assert told.items() >= PLAIN.items()
    assert Home.from_environment(told).folder == home.folder
    assert Home.from_environment(told).pipeline == home.pipeline


@pytest.mark.parametrize(("stage", "by_segment"), [("publish", False), (HELP, False), ("train", True)])
def test_what_publishes_reads_the_home_that_the_worker_has(
    home: Home, run: Callable[[bool], Path], stage: str, by_segment: bool
) -> None:
    told = stage_environment(home, stage, run(by_segment), SECRETS | PLAIN)
    assert Home.from_environment(told) == home
    assert told["AWS_SECRET_ACCESS_KEY"] == "a"


def test_a_run_that_says_nothing_of_segments_may_publish_them(home: Home, tmp_path: Path) -> None:
    (tmp_path / "run.json").write_text(json.dumps({"iterations": 3}))
    assert stage_environment(home, "train", tmp_path, SECRETS)["AWS_SECRET_ACCESS_KEY"] == "a"
    assert "AWS_SECRET_ACCESS_KEY" not in stage_environment(home, "encode", tmp_path, SECRETS)


def test_the_process_of_a_stage_has_no_secrets(home: Home, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "telling.py").write_text(
        "import os\ndef encode(run, progress):\n    (run / 'told').write_text(' '.join(os.environ))\n"
    )
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "a")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)

    async def nothing(progress: Progress) -> None: ...

    runner = StageRunner(dataclasses.replace(home, pipeline="telling"))
    assert not asyncio.run(runner.run("workflow", "encode", tmp_path, nothing)).error
    told = (tmp_path / "told").read_text().split()
    assert "HGS_HOME" in told
    assert not {"AWS_SECRET_ACCESS_KEY", "HGS_DATABASE_URL"} & set(told)
