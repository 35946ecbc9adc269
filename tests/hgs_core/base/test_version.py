from __future__ import annotations

import tomllib
from importlib.metadata import PackageNotFoundError

import pytest

from hgs_core.base import version
from tests.conftest import REPOSITORY


def test_the_version_is_the_one_that_pyproject_states() -> None:
    stated = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]["version"]
    assert version.software_version() == stated


def test_a_checkout_that_is_not_installed_has_an_unknown_version(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> str:
        raise PackageNotFoundError(name)

    monkeypatch.setattr(version, "version", missing)
    assert version.software_version() == "0+unknown"
