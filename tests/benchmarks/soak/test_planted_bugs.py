"""Bugs that are to be found must be there: each changes something of the product."""

from __future__ import annotations

import importlib
from enum import Enum
from types import ModuleType

import pytest

from benchmarks.soak.planted_bugs import BUGS, Bug


def test_every_bug_can_be_planted() -> None:
    assert set(BUGS) == set(Bug)


@pytest.mark.parametrize("bug", [bug for bug in Bug if bug is not Bug.LEAK])
def test_it_replaces_a_part_of_its_module(bug: Bug) -> None:
    place, plant = BUGS[bug]
    real = importlib.import_module(place)
    copy = ModuleType(place)
    for name, value in vars(real).items():
        is_own = isinstance(value, type) and value.__module__ == place and not issubclass(value, Enum)
        setattr(copy, name, type(name, (value,), {}) if is_own else value)
    before = {name: dict(vars(value)) if isinstance(value, type) else value for name, value in vars(copy).items()}
    plant(copy)
    after = {name: dict(vars(value)) if isinstance(value, type) else value for name, value in vars(copy).items()}
    assert before != after
