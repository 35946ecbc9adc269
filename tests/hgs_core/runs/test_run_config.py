"""The config of a run: presets, ranges, names and the JSON form."""

from __future__ import annotations

import dataclasses
import json
import math
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import pytest

from hgs_core.base.config_fields import flat_fields
from hgs_core.base.errors import InputError
from hgs_core.runs.run_config import PRESETS, RunConfig
from hgs_core.train.train_config import LearningRates, TrainConfig

FLAT = flat_fields(RunConfig().to_json())
NUMBERS = [name for name, value in FLAT.items() if type(value) in (int, float)]


@pytest.mark.parametrize("preset", PRESETS)
def test_every_preset_is_valid_and_survives_json(preset: str) -> None:
    config = RunConfig.for_preset(preset, capture={"hold_out": ["cam00", "3"]}, train={"learning_rates": {"rgb": 0.01}})
    assert RunConfig.from_json(json.loads(json.dumps(config.to_json()))) == config
    assert (config.preset, config.capture.hold_out, config.train.learning_rates.rgb) == (preset, ("cam00", "3"), 0.01)
    changed = {name for name, value in flat_fields(config.to_json()).items() if value != FLAT[name]}
    assert changed - {"preset", "capture.hold_out", "train.learning_rates.rgb"} == set(PRESETS[preset])


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("train.iterations", 0),
        ("train.iterations", 1.5),
        ("train.iterations", "many"),
        ("train.iterations", True),
        ("train.dssim", 1.5),
        ("train.backend", "cuda9"),
        ("train.antialiased", 1),
        ("train.motion_order", 4),
        ("train.motion_order", True),
        ("train.learning_rates.rgb", -1),
        ("train.learning_rates", 3),
        ("train.learning_rates", None),
        ("train.learning_rates.colour", 1),
        ("train.labels.initial", None),
        ("train.density.method", {}),
        ("train.iterations", {}),
        ("capture.hold_out", "cam00"),
        ("capture.hold_out", 3),
        ("capture.hold_out", {}),
        ("capture.hold_out", {"cam00": 1}),
        ("capture.hold_out", ["a", "a"]),
        ("capture.hold_out", ["\ud800"]),
        ("capture.hold_out", ["a\0b"]),
        ("capture.hold_out", ["x" * 256]),
        ("capture.hold_out", [str(k) for k in range(1001)]),
        ("encode.budget", "free"),
        ("preset", "ultra"),
        ("preset", []),
        ("preset", 3),
        ("train", 3),
        ("points", []),
        ("no_such_field", 1),
        ("train.no_such_field", 1),
    ],
)
def test_bad_fields_are_refused_by_their_path(field: str, value: Any) -> None:
    with pytest.raises(InputError) as refused:
        RunConfig.from_json({field: value})
    assert refused.value.where == f"config.{field}"
    assert len(str(refused.value)) < 1000


@pytest.mark.parametrize("name", NUMBERS)
def test_every_number_is_bounded(name: str) -> None:
    for value in (math.inf, -math.inf, math.nan, 1e300, -1e300, 10**400, 10**5000, True, "1", None, []):
        with pytest.raises(InputError, match=rf"config\.{name}: .*; give a (whole )?number from [0-9.]+ to [0-9.e]+"):
            RunConfig.from_json({name: value})


def test_configs_made_in_python_pass_the_same_check() -> None:
    with pytest.raises(InputError, match=r"config\.train\.learning_rates\.rgb: inf is out of range"):
        RunConfig(train=TrainConfig(learning_rates=LearningRates(rgb=math.inf)))
    with pytest.raises(InputError, match=r"config\.train: 'all night' is not an object"):
        RunConfig(train="all night")  # type: ignore[arg-type]


def test_whole_numbers_may_be_written_as_others() -> None:
    train = RunConfig.from_json({"train": {"iterations": 20.0, "motion_order": 5.0, "dssim": 1}}).train
    assert (train.iterations, train.motion_order, train.dssim) == (20, 5, 1.0)
    assert [type(value) for value in (train.iterations, train.motion_order, train.dssim)] == [int, int, float]


def test_an_unknown_preset_lists_the_known_ones() -> None:
    with pytest.raises(InputError, match="preview, standard, best"):
        RunConfig.for_preset("ultra")


@pytest.mark.parametrize("read", [RunConfig.from_json, lambda fields: RunConfig.for_preset("preview", **fields)])
def test_fields_have_two_spellings(read: Callable[[dict[str, Any]], RunConfig]) -> None:
    nested, dotted = (
        read(fields)
        for fields in (
            {"train": {"iterations": 7, "learning_rates": {"rgb": 0.1}}, "encode": {"budget": "low"}},
            {"train.iterations": 7, "train.learning_rates.rgb": 0.1, "encode.budget": "low"},
        )
    )
    assert nested == dotted
    assert (nested.train.iterations, nested.train.learning_rates.rgb, nested.encode.budget) == (7, 0.1, "low")


def test_a_changed_config_keeps_the_rest() -> None:
    config = RunConfig.for_preset("best", seed=3)
    changed = config.changed({"train.density.every": 20})
    assert changed.train.density.every == 20
    assert dataclasses.replace(changed, train=config.train) == config
    assert changed.train.density.max_static == config.train.density.max_static


def test_configs_and_stages_do_not_load_torch() -> None:
    code = "import sys, hgs_core.runs.stages, hgs_core.runs.run_config; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_field_without_its_stage_is_refused_with_its_path() -> None:
    with pytest.raises(InputError, match=r"config\.iterations: unknown field; did you mean train\.iterations\?"):
        RunConfig.from_json({"iterations": 7})
