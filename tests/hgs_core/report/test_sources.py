"""What a report reads of runs that earlier versions have made."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.progress import silent
from hgs_core.report.sources import read_run
from tests.hgs_core.report.finished_run import HISTORY, write_finished_run


def test_a_run_that_counts_cycles_is_read(tmp_path: Path) -> None:
    path = write_finished_run(tmp_path)
    (path / "eval.json").write_text("{}")
    curves = {"cycle" if name == "iteration" else name: values for name, values in HISTORY.items()}
    (path / "train.json").write_text(json.dumps({"seconds": 12.0, "cycles": 40, "history": curves}))
    run = read_run(path, silent)
    assert run.iterations == 40
    assert run.history is not None
    assert run.history.iteration == HISTORY["iteration"]
    (path / "train.json").write_text(json.dumps({"seconds": 12.0, "cycles": 40, "iterations": 40}))
    with pytest.raises(InputError, match=r"train\.json\.cycles: is the old name of iterations, and both are given"):
        read_run(path, silent)
