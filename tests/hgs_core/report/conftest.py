"""A finished run and its report."""

from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.progress import silent
from hgs_core.evaluate.run import evaluate_run
from hgs_core.report.write import write_report
from tests.hgs_core.report.finished_run import HISTORY, write_finished_run


@pytest.fixture(scope="session")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A measured run with a full record of its training."""
    folder = tmp_path_factory.mktemp("runs")
    path = write_finished_run(folder, history=HISTORY, profile={"frames": 3.0, "all step": 8.0})
    evaluate_run(path, silent)
    return path


@pytest.fixture(scope="session")
def other(run: Path) -> Path:
    """A run of the same capture that recorded nothing, and held out another camera."""
    return write_finished_run(run.parent, "a-rather-long-name-of-another-run", ("0", "3"))


@pytest.fixture(scope="session")
def report(run: Path, other: Path) -> Path:
    out = run.parent / "report.html"
    write_report(run, out, [other], silent)
    return out
