"""The training config: presets, ranges and its JSON form."""

from __future__ import annotations

import dataclasses
import json
import math
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from hgs_core.train.config import PRESETS, LearningRates, TrainConfig

NUMBERS = [
    *(field.name for field in dataclasses.fields(TrainConfig) if field.type in ("int", "float")),
    *(f"learning_rates.{field.name}" for field in dataclasses.fields(LearningRates)),
]


def with_value(name: str, value: Any) -> dict[str, Any]:
    """Return the JSON form of a config in which one field, maybe of the learning rates, has a value."""
    parent, _, rate = name.partition(".")
    return {parent: {rate: value}} if rate else {parent: value}


@pytest.mark.parametrize("preset", PRESETS)
def test_json_round_trip(preset: str) -> None:
    config = TrainConfig.for_preset(preset, hold_out=["cam00", "3"], learning_rates={"rgb": 0.01})
    assert TrainConfig.from_json(json.loads(json.dumps(config.to_json()))) == config


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("iterations", 0), ("iterations", 1.5), ("iterations", "many"), ("iterations", True), ("dssim", 1.5),
        ("hold_out", "cam00"), ("hold_out", ["a", "a"]), ("backend", "cuda9"), ("learning_rates", {"rgb": -1}),
        ("learning_rates", 3), ("learning_rates", {"colour": 1}), ("no_such_field", 1), ("preset", 3),
        ("antialiased", 1),
    ],
)  # fmt: skip
def test_a_bad_value_is_refused_by_name(field: str, value: Any) -> None:
    with pytest.raises(InputError, match=field):
        TrainConfig.from_json({field: value})


@pytest.mark.parametrize("name", NUMBERS)
def test_every_number_is_finite_and_bounded(name: str) -> None:
    for value in (math.inf, -math.inf, math.nan, 1e300, -1e300, 10**400, 10**5000, True, "1", None, []):
        with pytest.raises(InputError, match=rf"config\.{name}: .*; give a (whole )?number from [0-9.]+ to [0-9.e]+"):
            TrainConfig.from_json(with_value(name, value))


@pytest.mark.parametrize("name", NUMBERS)
def test_a_config_made_in_python_passes_the_same_check(name: str) -> None:
    parent, _, rate = name.partition(".")
    with pytest.raises(InputError, match=rf"config\.{name}: inf is out of range"):
        TrainConfig(**{parent: LearningRates(**{rate: math.inf}) if rate else math.inf})


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("hold_out", 3), ("hold_out", {"cam00": 1}), ("hold_out", ["\ud800"]), ("hold_out", ["a\0b"]),
        ("hold_out", ["x" * 256]), ("hold_out", [str(k) for k in range(1001)]), ("motion_order", True),
        ("motion_order", 4), ("preset", "ultra"), ("preset", []), ("labels", None), ("learning_rates", None),
    ],
)  # fmt: skip
def test_names_and_choices_are_bounded(field: str, value: Any) -> None:
    with pytest.raises(InputError, match=field) as refused:
        TrainConfig.from_json({field: value})
    assert len(str(refused.value)) < 1000


@pytest.mark.parametrize("read", [TrainConfig.from_json, lambda fields: TrainConfig.for_preset("preview", **fields)])
def test_the_old_name_of_iterations_is_read(read: Callable[[dict[str, Any]], TrainConfig]) -> None:
    assert read({"cycles": 7}).iterations == 7
    with pytest.raises(InputError, match=r"config\.cycles: is the old name of iterations, and both are given"):
        read({"cycles": 7, "iterations": 7})


def test_whole_numbers_may_be_written_as_others() -> None:
    config = TrainConfig.from_json({"iterations": 20.0, "motion_order": 5.0, "dssim": 1})
    assert (config.iterations, config.motion_order, config.dssim) == (20, 5, 1.0)
    assert [type(value) for value in (config.iterations, config.motion_order, config.dssim)] == [int, int, float]


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
