"""The training config: presets, ranges and its JSON form."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from hgs_core.train.config import PRESETS, TrainConfig


@pytest.mark.parametrize("preset", PRESETS)
def test_json_round_trip(preset: str) -> None:
    config = TrainConfig.for_preset(preset, hold_out=["cam00", "3"], learning_rates={"rgb": 0.01})
    assert TrainConfig.from_json(json.loads(json.dumps(config.to_json()))) == config


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("cycles", 0), ("cycles", 1.5), ("cycles", "many"), ("cycles", True), ("dssim", 1.5), ("hold_out", "cam00"),
        ("hold_out", ["a", "a"]), ("backend", "cuda9"), ("learning_rates", {"rgb": -1}), ("learning_rates", 3),
        ("learning_rates", {"colour": 1}), ("no_such_field", 1), ("preset", 3), ("antialiased", 1),
    ],
)  # fmt: skip
def test_a_bad_value_is_refused_by_name(field: str, value: Any) -> None:
    with pytest.raises(InputError, match=field):
        TrainConfig.from_json({field: value})


def test_an_unknown_preset_lists_the_known_ones() -> None:
    with pytest.raises(InputError, match="preview, standard, best"):
        TrainConfig.for_preset("ultra")


@pytest.mark.parametrize(("labels", "budgets"), [("auto", (100, 75)), ("dynamic", (100, 175)), ("static", (175, 75))])
def test_budgets_grow_with_time_and_a_single_set_has_both(labels: str, budgets: tuple[int, int]) -> None:
    config = TrainConfig(max_static=100, max_dynamic=30, dynamic_points=8, labels=labels)
    assert config.splat_budgets(2.5) == budgets
    assert config.splat_budgets(0.1) == TrainConfig(max_static=100, max_dynamic=30, labels=labels).splat_budgets(1.0)
    assert (config.first_dynamic_points(2.5), config.first_dynamic_points(0.0)) == (20, 8)


def test_config_and_pipeline_do_not_load_torch() -> None:
    code = "import sys, hgs_core.runs.stages, hgs_core.train.config; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
