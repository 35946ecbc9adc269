from __future__ import annotations

import dataclasses

import pytest

from hgs_core.ablate.ablation_rows import FULL, ROWS, rows_named
from hgs_core.base.errors import InputError
from hgs_core.runs.run_config import PRESETS, RunConfig

AS_THE_PRESET_HAS_IT = {("preview", "discs")}  # the row of this preset is another full run


@pytest.mark.parametrize("name", ROWS)
@pytest.mark.parametrize("preset", PRESETS)
def test_every_row_changes_one_thing_of_a_valid_config(name: str, preset: str) -> None:
    row, base = ROWS[name], RunConfig.for_preset(preset, capture={"hold_out": ["cam00"]})
    config = row.config(base, 3)
    assert config == RunConfig.from_json(config.to_json())
    assert config.capture == base.capture
    assert (config.seed, config.train.iterations) == (3, base.train.iterations)
    changes = [dataclasses.replace(config, seed=base.seed) != base, row.masks is not None, row.statics_at_rest]
    assert sum(changes) == (row != FULL and (preset, name) not in AS_THE_PRESET_HAS_IT)
    assert row.asks


def test_the_full_method_comes_first_whether_named_or_not() -> None:
    assert [row.name for row in rows_named(["order-2", "order-1", "order-2"])] == ["full", "order-2", "order-1"]
    assert [row.name for row in rows_named(None)] == list(ROWS)


def test_an_unknown_row_names_those_there_are() -> None:
    with pytest.raises(InputError, match=r"'order-4'.*order-1, order-2"):
        rows_named(["order-4"])
