from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
from pathlib import Path

import pytest

from jobs.home.home import Home
from jobs.home.stage_limits import StageLimits
from jobs.home.stage_settings import StageBytes, StageCount
from jobs.process.landlock import landlock_version


def test_a_command_has_the_limits_of_the_stage(home: Home) -> None:
    limits = StageLimits(memory=StageBytes(8e9), files=StageCount(99, (("train", 77),)), file_size=StageBytes(1e9))
    limited = dataclasses.replace(home, limits=limits)
    tell = "import resource as r; print(*(r.getrlimit(k)[0] for k in (r.RLIMIT_NOFILE, r.RLIMIT_FSIZE, r.RLIMIT_DATA)))"
    command = [sys.executable, "-m", "jobs.process.limited", "train", str(home.folder), sys.executable, "-c", tell]
    told = subprocess.check_output(command, env={**os.environ, **limited.environment()}, text=True)
    assert told.split() == ["77", "1000000000", "8000000000"]


@pytest.mark.skipif(landlock_version() == 0, reason="the kernel has no Landlock")
def test_a_command_reads_its_capture_and_nothing_else(home: Home, tmp_path: Path) -> None:
    for name in ("capture", "other"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "file").touch()
    command = [sys.executable, "-P", "-m", "jobs.process.limited", "train", str(tmp_path / "capture")]

    def ended(act: str) -> int:
        program = [sys.executable, "-c", act]
        environment = {**os.environ, **home.environment()}
        return subprocess.run([*command, *program], env=environment, stderr=subprocess.DEVNULL).returncode

    files = [str(tmp_path / name / "file") for name in ("capture", "other")]
    assert [ended(f"open({file!r})") for file in files] == [0, 1]
    assert ended(f"open({files[0]!r}, 'a')") == 1
