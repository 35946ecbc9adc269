from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.soak.planted_bugs import PLANTED, Bug
from tests.conftest import REPOSITORY

ASK = "from jobs.artifacts.artifact_store import ArtifactStore; print(ArtifactStore.rename_scene.__module__)"


def answer(code: str, **environment: str) -> str:
    path = os.pathsep.join((str(PLANTED), environment.get("HGS_SOAK_CHECKOUT", str(REPOSITORY))))
    command = [sys.executable, "-P", "-c", code]
    return subprocess.check_output(command, env={**os.environ, **environment, "PYTHONPATH": path}, text=True).strip()


@pytest.mark.parametrize(
    ("environment", "module"),
    [({}, "jobs.artifacts.artifact_store"), ({"HGS_SOAK_BUG": Bug.LOST_TITLE}, "planted_bugs")],
)
def test_the_bug_that_is_named_is_planted(environment: dict[str, str], module: str) -> None:
    assert answer(ASK, **environment) == module


def test_a_checkout_comes_before_the_installed_one(tmp_path: Path) -> None:
    (tmp_path / "jobs").mkdir()
    (tmp_path / "jobs" / "__init__.py").write_text("")
    told = answer("import jobs; print(jobs.__file__)", HGS_SOAK_CHECKOUT=str(tmp_path))
    assert told == str(tmp_path / "jobs" / "__init__.py")
