"""The options of `hgs train` and `hgs submit` that choose what a training does."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.train.config import TrainConfig
from server.cli.training_options import add_masks_option, add_training_options, training_config


def config_of(*arguments: str) -> TrainConfig:
    parser = argparse.ArgumentParser()
    add_training_options(parser)
    return training_config(parser.parse_args(arguments))


def test_without_options_the_config_is_the_preset_standard() -> None:
    assert config_of() == TrainConfig.for_preset("standard")


def test_pictures_are_reduced_as_asked() -> None:
    assert config_of("--downscale", "4").downscale == 4


@pytest.mark.parametrize(
    ("assignment", "word"),
    [
        ("iterations", "KEY=VALUE"),
        ("cycels=3", "cycels"),
        ("iterations=many", "iterations"),
        ("iterations=0", "iterations"),
        ("learning_rates.opacity=-1", "learning_rates.opacity"),
        ("seed.x=1", "seed"),
        ("iterations=Infinity", "config.iterations: inf is out of range"),
        ("dssim=NaN", "config.dssim: nan is out of range"),
        ("checkpoint_every=1000000000", "config.checkpoint_every: 1000000000 is out of range"),
        ("iterations=" + "9" * 5000, "config.iterations"),
        ("hold_out=" + "[" * 5000, "config.hold_out"),
        ("hold_out=3", "config.hold_out"),
    ],
    ids=lambda text: text[:24],
)
def test_bad_overrides_are_refused(assignment: str, word: str) -> None:
    with pytest.raises(InputError) as caught:
        config_of("--set", assignment)
    assert word in str(caught.value)


def test_overrides_are_read_as_json_and_nest() -> None:
    config = config_of(
        "--preset", "preview", "--hold-out", "a, b", "--set", "iterations=9", "backend=cpu",
        "--set", "learning_rates.opacity=0.5",
    )  # fmt: skip
    assert (config.preset, config.hold_out, config.iterations, config.backend) == ("preview", ("a", "b"), 9, "cpu")
    assert config.learning_rates.opacity == 0.5


def test_a_field_cannot_be_set_and_nested_in_at_once() -> None:
    with pytest.raises(InputError, match=r"--set seed\.x=1: seed is already set to a single value"):
        config_of("--set", "seed=3", "seed.x=1")


def test_masks_are_a_folder_or_none() -> None:
    parser = argparse.ArgumentParser()
    add_masks_option(parser)
    assert parser.parse_args([]).masks is None
    assert parser.parse_args(["--masks", "given"]).masks == Path("given")
