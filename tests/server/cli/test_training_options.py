"""The training options of `hgs train` and `hgs submit`."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.held_out import AUTO
from hgs_core.runs.run_config import RunConfig
from server.cli.training_options import add_given_options, add_training_options, training_config


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


def test_a_field_cannot_be_set_and_nested_in_at_once() -> None:
    with pytest.raises(InputError, match=r"config\.seed\.x: config\.seed\.x is given twice"):
        config_of("--set", "seed=3", "seed.x=1")


def test_masks_are_a_folder_or_none() -> None:
    parser = argparse.ArgumentParser()
    add_given_options(parser)
    assert parser.parse_args([]).masks is None
    assert parser.parse_args(["--masks", "given"]).masks == Path("given")
