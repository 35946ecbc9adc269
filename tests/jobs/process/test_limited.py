from __future__ import annotations

import dataclasses
import os
import subprocess
import sys

from jobs.home.home import Home
from jobs.home.stage_limits import StageLimits
from jobs.home.stage_settings import StageBytes, StageCount


def test_a_command_has_the_limits_of_the_stage(home: Home) -> None:
    limits = StageLimits(memory=StageBytes(8e9), files=StageCount(99, (("train", 77),)), file_size=StageBytes(1e9))
    limited = dataclasses.replace(home, limits=limits)
    tell = "import resource as r; print(*(r.getrlimit(k)[0] for k in (r.RLIMIT_NOFILE, r.RLIMIT_FSIZE, r.RLIMIT_DATA)))"
    command = [sys.executable, "-m", "jobs.process.limited", "train", sys.executable, "-c", tell]
    told = subprocess.check_output(command, env={**os.environ, **limited.environment()}, text=True)
    assert told.split() == ["77", "1000000000", "8000000000"]
