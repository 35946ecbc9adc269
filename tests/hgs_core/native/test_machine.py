from __future__ import annotations

import json
import os
from pathlib import Path
from types import SimpleNamespace

import pytest

from hgs_core.native import library, machine

CPUINFO = "processor\t: 0\nmodel name\t: Fast One: 3 GHz\nflags\t: avx\n\nprocessor\t: 1\nmodel name\t: Slow One\n"


def test_the_facts_are_plain_json_and_name_the_kernels_in_use() -> None:
    facts = json.loads(json.dumps(machine.machine_facts()))
    assert facts["instruction_set"] == library.instruction_set()
    assert set(facts) == {"cpu", "cores", "load", "system", "instruction_set", "python", "torch", "numpy", "hgs"}


def test_cores_are_those_that_the_process_may_use(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0, 3, 5}, raising=False)
    assert machine.machine_facts()["cores"] == 3


def test_the_processor_is_the_first_that_linux_names(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine, "Path", lambda path: SimpleNamespace(read_text=lambda: CPUINFO))
    assert machine.machine_facts()["cpu"] == "Fast One: 3 GHz"


def test_where_there_is_no_cpuinfo_python_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(path: str) -> Path:
        raise FileNotFoundError(path)

    monkeypatch.setattr(machine, "Path", absent)
    for name, told in (("riscv", "riscv"), ("", "unknown")):
        monkeypatch.setattr(machine.platform, "processor", lambda name=name: name)
        assert machine.machine_facts()["cpu"] == told
