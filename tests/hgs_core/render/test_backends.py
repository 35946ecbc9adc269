"""The choice of a backend."""

from __future__ import annotations

import pytest
import torch

from hgs_core.base.errors import InputError
from hgs_core.native import library
from hgs_core.render import backends
from hgs_core.render.backends import choose_backend, training_device
from tests.hgs_core.render.scenes import dynamic_splats, static_splats

FLOATS = static_splats(1, dtype=torch.float32), dynamic_splats(1, dtype=torch.float32)


def test_auto_is_the_compiled_one_for_float32_on_the_cpu(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "available", lambda: True)
    assert choose_backend("auto", *FLOATS) == "cpu"
    assert choose_backend("auto", None) == "cpu"


def test_auto_is_the_reference_where_either_set_is_not_float32(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "available", lambda: True)
    assert choose_backend("auto", static_splats(1), None) == "reference"
    assert choose_backend("auto", FLOATS[0], dynamic_splats(1)) == "reference"


def test_auto_is_the_reference_where_the_library_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "available", lambda: False)
    assert choose_backend("auto", *FLOATS) == "reference"


def test_auto_is_triton_where_it_can_draw_both_sets(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "available", lambda: True)
    monkeypatch.setattr(backends, "available", lambda colours: colours is FLOATS[0].rgb)
    assert choose_backend("auto", FLOATS[0]) == "triton"
    assert choose_backend("auto", *FLOATS) == "cpu"  # the dynamic ones are not on a device of Triton's


@pytest.mark.parametrize("name", ["cpu", "reference"])
def test_a_name_is_taken_at_its_word(name: str) -> None:
    assert choose_backend(name, static_splats(1)) == name


def test_triton_is_asked_for_where_it_can_run(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[object] = []
    monkeypatch.setattr(backends, "require_device", asked.append)
    assert choose_backend("triton", *FLOATS) == "triton"
    assert asked == [FLOATS[0].rgb]


def test_an_unknown_name_is_refused_with_those_that_are_known() -> None:
    with pytest.raises(InputError, match="unknown backend 'vulkan'; use auto, cpu, triton or reference"):
        choose_backend("vulkan", None)


def test_a_training_lives_where_its_backend_draws(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(backends, "require_device", lambda: torch.device("cuda", 3))
    assert training_device("triton") == torch.device("cuda", 3)
    assert training_device("cpu") == training_device("reference") == torch.device("cpu")
