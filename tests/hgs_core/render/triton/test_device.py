"""Without Triton or a CUDA device the backend names the missing part."""

from __future__ import annotations

import importlib.util

import pytest
import torch

from hgs_core.base.errors import InputError
from hgs_core.render.triton.device import available, require_device


def test_a_missing_package_is_named_with_its_cure(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"package triton.*not installed; install hgs\[gpu\]"):
        require_device()


def test_a_missing_device_is_named_with_its_cure(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: object())
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    monkeypatch.delenv("TRITON_INTERPRET", raising=False)
    with pytest.raises(InputError, match=r"needs a CUDA device.*sees none; install a torch with CUDA.*or use cpu"):
        require_device(torch.zeros(1))


def test_tensors_on_the_cpu_are_left_to_the_other_backends() -> None:
    assert not available(torch.zeros(1))
