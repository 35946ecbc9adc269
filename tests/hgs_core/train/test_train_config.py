"""The budgets that a training config gives its sets; that every field is checked is tested with the run's config."""

from __future__ import annotations

import pytest

from hgs_core.train.density_config import DensityConfig
from hgs_core.train.train_config import LabelConfig, TrainConfig


@pytest.mark.parametrize(("labels", "budgets"), [("auto", (100, 75)), ("dynamic", (100, 175)), ("static", (175, 75))])
def test_budgets_grow_with_time_and_a_single_set_has_both(labels: str, budgets: tuple[int, int]) -> None:
    config = TrainConfig(density=DensityConfig(max_static=100, max_dynamic=30), labels=LabelConfig(initial=labels))
    assert config.splat_budgets(2.5) == budgets
    assert config.splat_budgets(0.1) == config.splat_budgets(1.0)
