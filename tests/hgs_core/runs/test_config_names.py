"""Configs of earlier versions: every field of theirs has its place."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from hgs_core.base.config_fields import flat_fields
from hgs_core.base.errors import InputError
from hgs_core.runs.config_names import OLD_NAMES, by_stage
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder, RunSpec
from tests.conftest import REPOSITORY

FLAT_CONFIG: dict[str, Any] = json.loads((Path(__file__).parent / "flat_config.json").read_text())
"""What version 0.1.0 wrote into run.json before configs had stages, each value another than the default."""

LATER = {
    "capture.downscale_cameras",
    "capture.sync",
    "capture.trust_poses",
    "encode.by_segment",
    "points.continued",
    "points.discs",
    "points.stereo",
    "train.average_from",
    "train.density.dynamic_opacity_penalty",
    "train.density.static_opacity_penalty",
    "train.elongation",
    "train.held_statics",
    "train.hold_from",
    "train.learning_rates.lens_falloff",
    "train.lens_falloff",
    "train.moving_steps",
}
"""Fields that no flat config had."""


def test_a_flat_config_is_read_whole() -> None:
    config = RunConfig.from_json(FLAT_CONFIG)
    default, read = flat_fields(RunConfig().to_json()), flat_fields(config.to_json())
    assert all(read[name] != default[name] for name in set(default) - LATER)
    for name, value in flat_fields(FLAT_CONFIG).items():
        first, dot, rest = name.partition(".")
        assert read[OLD_NAMES.get(first, first) + dot + rest] == value


def test_a_run_of_an_earlier_version_is_the_same_run(tmp_path: Path) -> None:
    run = RunFolder(tmp_path / "run")
    run.path.mkdir()
    run.spec.write_text(json.dumps({"capture": str(tmp_path), "fingerprint": "f", "config": FLAT_CONFIG}))
    run.write_spec(RunSpec(tmp_path, "f", RunConfig.from_json(FLAT_CONFIG)))  # refuses another run
    with pytest.raises(InputError, match="another capture or config"):
        run.write_spec(RunSpec(tmp_path, "f", RunConfig()))


def test_every_old_name_leads_to_a_field() -> None:
    fields = flat_fields(RunConfig().to_json())
    assert {path for path in OLD_NAMES.values() if path not in fields} == {"train.learning_rates"}
    assert set(fields) - LATER == {"preset", "seed", *OLD_NAMES.values()} - {"train.learning_rates"} | {
        name for name in set(fields) - LATER if name.startswith("train.learning_rates.")
    }


def test_the_documented_names_are_those_that_are_read() -> None:
    text = (REPOSITORY / "docs" / "training.md").read_text()
    rows = re.findall(r"^\| `([\w.]+)` \| (`.*`) \|$", text, re.M)
    assert {old: path for path, names in rows for old in re.findall(r"`(\w+)`", names)} == OLD_NAMES


@pytest.mark.parametrize(
    "values",
    [
        {"cycles": 5, "iterations": 5},
        {"iterations": 5, "train": {"iterations": 6}},
        {"train": {"iterations": 6}, "train.iterations": 5},
        {"learning_rates": {"rgb": 1}, "train.learning_rates.rgb": 1},
        {"learning_rates": 3, "learning_rates.rgb": 1},
        {"train": 3, "iterations": 5},
    ],
)
def test_a_field_under_two_names_is_refused(values: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=r"config\.train.* is given twice; give it once"):
        by_stage(values)


def test_parts_may_be_given_in_pieces_and_what_is_given_stays_as_it_is() -> None:
    given = {"train": {"learning_rates": {"rgb": 1}}, "learning_rates": {"opacity": 2}, "train.dssim": 0.1, "seed": 3}
    before = json.dumps(given)
    assert by_stage(given) == {"train": {"learning_rates": {"rgb": 1, "opacity": 2}, "dssim": 0.1}, "seed": 3}
    assert json.dumps(given) == before
