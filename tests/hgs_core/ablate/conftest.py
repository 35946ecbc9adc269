"""An ablation of a capture so small that it says nothing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from hgs_core.ablate.ablation_rows import rows_named
from hgs_core.ablate.plan import Ablation
from hgs_core.runs.run_config import RunConfig
from tests.synthetic import write_capture

CONFIG = RunConfig.from_json(
    {
        "capture": {"hold_out": ["1"]},
        "points": {"static": 100, "dynamic": 40, "interval": 0.07},
        "train": {"iterations": 3, "density": {"every": 2, "max_static": 150, "max_dynamic": 60}},
    }
)

MakeAblation = Callable[..., Ablation]


@pytest.fixture(scope="session")
def tiny_capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("ablate") / "capture"
    write_capture(path, cameras=4, frames=4, width=48, height=36)
    return path


@pytest.fixture(scope="session")
def make_ablation(tiny_capture: Path) -> MakeAblation:
    """Return a function that describes an ablation of the tiny capture."""

    def make(out: Path, rows: list[str] | None = None, seeds: tuple[int, ...] = (0,), **others: Path) -> Ablation:
        return Ablation(tiny_capture, out, CONFIG, rows_named(rows), seeds, **others)

    return make
