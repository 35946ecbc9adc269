"""The choice of a library, and its settings in the environment."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from hgs_core.native import library

PRINT = "from hgs_core.native import library; print(library.available(), library.instruction_set())"


def in_new_process(code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    inherited = {name: value for name, value in os.environ.items() if not name.startswith("HGS_")}
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        env={**inherited, **environment},
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_environment_forces_an_instruction_set() -> None:
    for name in library.supported():
        assert in_new_process(PRINT, HGS_NATIVE_ISA=name).stdout.split() == ["True", name]


def test_the_environment_switches_the_kernels_off_without_a_warning() -> None:
    result = in_new_process(PRINT, HGS_NATIVE_ISA="none")
    assert result.stdout.split() == ["False", "None"], result.stderr


def test_an_unknown_instruction_set_is_named() -> None:
    result = in_new_process(PRINT, HGS_NATIVE_ISA="v9")
    assert "InputError: HGS_NATIVE_ISA: there is no library for 'v9'; use one of" in result.stderr


def test_a_missing_library_is_warned_about_once() -> None:
    code = (
        "import pathlib, warnings; pathlib.Path.glob = lambda *_: iter(())\n"
        "from hgs_core.native import library\n"
        "with warnings.catch_warnings(record=True) as caught:\n"
        "    warnings.simplefilter('always')\n"
        "    print(library.available(), library.available(), len(caught))\n"
    )
    result = in_new_process(code)
    assert result.stdout.split() == ["False", "False", "1"], result.stderr


def test_statuses_become_exceptions() -> None:
    library.check(0)
    with pytest.raises(MemoryError, match="out of memory"):
        library.check(1)
    with pytest.raises(RuntimeError, match="tiles"):
        library.check(2)
