"""The whole of it, for a minute."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest

from benchmarks.soak.soak_run import soak
from benchmarks.soak.soaked_service import Extras
from tests.jobs.modules import postgres_server, s3_server


@pytest.mark.slow
@pytest.mark.timeout(1200)
@pytest.mark.skipif(bool(postgres_server.missing_program() or s3_server.missing_program()), reason="no servers")
def test_a_sound_service_is_found_sound() -> None:
    # Not tmp_path: Postgres runs as another user where this runs as root, and may not enter that.
    with tempfile.TemporaryDirectory(prefix="hgs-soak-") as name:
        folder = Path(name)
        folder.chmod(0o755)
        result = soak(folder, 1, 1.0, Extras())
        assert not result.findings
        assert not result.steep
        assert result.faults
        assert (folder / "report.html").is_file()
