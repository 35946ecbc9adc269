"""The first command of the README, as a stranger runs it."""

from __future__ import annotations

import json
import subprocess

import pytest

from tests.conftest import REPOSITORY


@pytest.mark.slow
def test_the_demo_checks_itself() -> None:
    result = subprocess.run(
        [REPOSITORY / "scripts" / "demo", "--check"], capture_output=True, text=True, check=False, timeout=550
    )
    assert result.returncode == 0, result.stderr[-2000:]
    report = json.loads(result.stdout.splitlines()[-1])
    assert report["ok"]
    assert report["splats_dynamic"] > 0
