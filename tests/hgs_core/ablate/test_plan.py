from __future__ import annotations

from pathlib import Path

from hgs_core.ablate.ablation_rows import rows_named
from hgs_core.ablate.plan import Ablation
from hgs_core.runs.run_config import RunConfig

BASE = RunConfig.for_preset("preview", seed=99, capture={"hold_out": ["0"]})


def ablation(**more: Path) -> Ablation:
    return Ablation(Path("capture"), Path("out"), BASE, rows_named(["order-1"]), (4, 7), **more)


def test_all_rows_are_trained_with_one_seed_before_the_next() -> None:
    assert [(run.row.name, run.seed) for run in ablation().runs()] == [
        ("full", 4),
        ("order-1", 4),
        ("full", 7),
        ("order-1", 7),
    ]


def test_every_run_has_a_folder_of_its_own_and_its_rows_config_with_its_seed() -> None:
    run = ablation().runs()[3]
    assert run.path == Path("out/order-1/seed-7")
    assert run.folder.train_summary.is_relative_to(run.path)
    assert (run.config.seed, run.config.train.motion_order, run.config.capture) == (7, 1, BASE.capture)


def test_sources_are_full_paths_of_what_was_given(tmp_path: Path) -> None:
    given = ablation(truth=tmp_path / "a" / ".." / "truth", score_masks=tmp_path)
    expected = {"masks": None, "truth": str(tmp_path / "truth"), "score_masks": str(tmp_path)}
    assert given.sources() == expected
