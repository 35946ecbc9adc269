"""The kernels compile for real GPUs: the interpreter is more lenient than the compiler."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import REPOSITORY

KERNELS = {
    "project_statics",
    "project_dynamics",
    "count_tiles",
    "emit_tiles",
    "place_entries",
    "composite",
    "composite_backward",
    "reduce_slots",
    "differentiate_statics",
    "differentiate_dynamics",
    "weigh",
    "rmsprop",
    "blur_pictures",
    "differentiate_ssim",
    "blur_derivatives",
    "write_gradient",
}


@pytest.mark.slow
@pytest.mark.parametrize("capability", [80, 90])
def test_every_launch_compiles(capability: int, tmp_path: Path) -> None:
    environment = {name: value for name, value in os.environ.items() if name != "TRITON_INTERPRET"}
    result = subprocess.run(
        [sys.executable, "-m", "tests.hgs_core.render.triton.ahead_of_time", str(capability)],
        cwd=REPOSITORY,
        env=environment | {"TRITON_CACHE_DIR": str(tmp_path)},
        capture_output=True,
        text=True,
    )
    assert result.returncode == 0, result.stderr
    built = [json.loads(line) for line in result.stdout.splitlines()]
    assert {launch["kernel"] for launch in built} == KERNELS
    assert all(launch["capability"] == capability and launch["bytes"] > 0 for launch in built)
