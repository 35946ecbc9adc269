"""The options of `hgs train` and `hgs submit` that choose what a training does."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.held_out import AUTO
from hgs_core.runs.run_config import RunConfig
from server.cli.training_options import add_masks_option, add_training_options, training_config


def config_of(*arguments: str) -> RunConfig:
    parser = argparse.ArgumentParser()
    add_training_options(parser)
    return training_config(parser.parse_args(arguments))


def test_without_options_the_config_is_the_preset_standard() -> None:
    assert config_of() == RunConfig.for_preset("standard", capture={"hold_out": AUTO})


def test_nobody_is_held_out_where_none_is_asked_for() -> None:
    assert config_of("--hold-out", "none").capture.hold_out == ()


def test_poses_are_trusted_where_that_is_asked_for() -> None:
    assert not config_of().capture.trust_poses
    assert config_of("--trust-poses").capture.trust_poses


def test_pictures_are_reduced_as_asked() -> None:
    assert config_of("--downscale", "4").capture.downscale == 4
    some = config_of("--downscale", "2,cam04=8").capture
    assert (some.downscale, some.reductions) == (2, {"cam04": 8})
    assert config_of("--downscale", "cam04=8").capture.downscale == 1


def test_the_way_to_synchronise_is_as_asked() -> None:
    assert config_of().capture.sync == "auto"
    assert config_of("--sync", "audio").capture.sync == "audio"


@pytest.mark.parametrize(
    ("assignment", "word"),
    [
        ("iterations", "KEY=VALUE"),
        ("cycels=3", "cycels"),
        ("iterations=many", "iterations"),
        ("iterations=0", "iterations"),
        ("learning_rates.opacity=-1", "learning_rates.opacity"),
        ("seed.x=1", "seed"),
        ("iterations=Infinity", "config.train.iterations: inf is out of range"),
        ("dssim=NaN", "config.train.dssim: nan is out of range"),
        ("checkpoint_every=1000000000", "config.train.checkpoint_every: 1000000000 is out of range"),
        ("iterations=" + "9" * 5000, "config.train.iterations"),
        ("hold_out=" + "[" * 5000, "config.capture.hold_out"),
        ("hold_out=3", "config.capture.hold_out"),
        ("train.iterations=0", "config.train.iterations: 0 is out of range"),
        ("encode.budget=free", "config.encode.budget: unknown choice 'free'; use low, default or high"),
        ("train=3", "config.train: 3 is not an object"),
    ],
    ids=lambda text: text[:24],
)
def test_bad_overrides_are_refused(assignment: str, word: str) -> None:
    with pytest.raises(InputError) as caught:
        config_of("--set", assignment)
    assert word in str(caught.value)


def test_overrides_are_read_as_json_and_nest() -> None:
    config = config_of(
        "--preset",
        "preview",
        "--hold-out",
        "a, b",
        "--set",
        "train.iterations=9",
        "encode.budget=low",
        "--set",
        "train.learning_rates.opacity=0.5",
        'points={"static": 7}',
    )
    assert (config.preset, config.capture.hold_out, config.points.static) == ("preview", ("a", "b"), 7)
    assert (config.train.iterations, config.encode.budget, config.train.learning_rates.opacity) == (9, "low", 0.5)


def test_overrides_may_have_their_old_names() -> None:
    old = config_of("--set", "cycles=9", "backend=cpu", "learning_rates.opacity=0.5", "labels=static")
    new = config_of(
        "--set",
        "train.iterations=9",
        "train.backend=cpu",
        "train.learning_rates.opacity=0.5",
        "train.labels.initial=static",
    )
    assert old == new


def test_a_field_cannot_be_set_and_nested_in_at_once() -> None:
    with pytest.raises(InputError, match=r"config\.seed\.x: config\.seed\.x is given twice"):
        config_of("--set", "seed=3", "seed.x=1")


def test_masks_are_a_folder_or_none() -> None:
    parser = argparse.ArgumentParser()
    add_masks_option(parser)
    assert parser.parse_args([]).masks is None
    assert parser.parse_args(["--masks", "given"]).masks == Path("given")
