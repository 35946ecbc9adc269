from __future__ import annotations

import math
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from hgs_core.bench.raster.raster_settings import BenchSettings, parse_backends, parse_threads
from hgs_core.bench.raster.raster_sizes import DEFAULT_SIZES, Size
from hgs_core.native import library


def test_defaults_are_the_documented_matrix(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "available", lambda: True)
    monkeypatch.setenv("HGS_THREADS", "6")
    settings = BenchSettings.of()
    assert settings.sizes == DEFAULT_SIZES
    assert settings.threads == (1, 6)
    assert settings.backends == ("cpu", "reference")
    assert [str(size) for size in settings.truth] == ["20k@338x253", "20k@676x507"]


def test_without_kernels_only_the_reference_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "available", lambda: False)
    assert BenchSettings.of().backends == ("reference",)


def test_cpu_backend_without_kernels_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "available", lambda: False)
    with pytest.raises(InputError, match="there are none; install a C"):
        BenchSettings.of(backends=("cpu", "reference"))


@pytest.mark.parametrize(
    ("wrong", "word"),
    [
        ({"seconds": 0.0}, "--seconds"),
        ({"seconds": math.nan}, "--seconds"),
        ({"dynamic_share": 1.0}, "--dynamic"),
        ({"seed": -1}, "--seed"),
        ({"truth": (Size(5, 6, 7),)}, "--truth"),
        ({"truth": (), "backends": ("reference",)}, "--truth"),
    ],
)
def test_values_out_of_range_are_refused(wrong: dict[str, Any], word: str) -> None:
    with pytest.raises(InputError, match=f"^{word}: "):
        BenchSettings.of(**wrong)


def test_threads_are_read_in_ascending_order() -> None:
    assert parse_threads("--threads", "4, 1,2,4") == (1, 2, 4)


@pytest.mark.parametrize("text", ["", "0", "-1", "1.5", "two", "1,", "5000"])
def test_numbers_of_threads_that_cannot_be_are_refused(text: str) -> None:
    with pytest.raises(InputError, match="--threads"):
        parse_threads("--threads", text)


def test_unknown_backend_is_refused() -> None:
    assert parse_backends("--backends", "reference, cpu") == ("cpu", "reference")
    with pytest.raises(InputError, match="'gpu'; choose from cpu, reference"):
        parse_backends("--backends", "cpu,gpu")
