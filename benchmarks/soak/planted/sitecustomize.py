"""Imported by Python at the start of every process of a soak: plants the bug that its environment names, if any."""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Callable
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import Any

__all__: list[str] = []


class _Planting(Loader):
    """A loader that changes a module once it is loaded."""

    def __init__(self, loader: Any, plant: Callable[[ModuleType], None]) -> None:
        self._loader, self._plant = loader, plant

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        found: ModuleType | None = self._loader.create_module(spec)
        return found

    def exec_module(self, module: ModuleType) -> None:
        self._loader.exec_module(module)
        self._plant(module)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._loader, name)


class _Finder(MetaPathFinder):
    """A finder of the one module that a bug is planted in."""

    def __init__(self, name: str, plant: Callable[[ModuleType], None]) -> None:
        self._name, self._plant = name, plant

    def find_spec(self, name: str, path: Any, target: ModuleType | None = None) -> ModuleSpec | None:
        if name != self._name:
            return None
        sys.meta_path.remove(self)
        spec = importlib.util.find_spec(name)
        if spec is not None and spec.loader is not None:
            spec.loader = _Planting(spec.loader, self._plant)
        return spec


def _leave_editable_installation() -> None:
    """Let imports come from the checkout on the path, not from the one that is installed."""
    sys.meta_path[:] = [finder for finder in sys.meta_path if "editable" not in type(finder).__module__]


if os.environ.get("HGS_SOAK_CHECKOUT"):
    _leave_editable_installation()
elif bug := os.environ.get("HGS_SOAK_BUG"):
    _spec = importlib.util.spec_from_file_location("planted_bugs", Path(__file__).parent.parent / "planted_bugs.py")
    assert _spec is not None
    assert _spec.loader is not None
    _bugs = importlib.util.module_from_spec(_spec)
    sys.modules["planted_bugs"] = _bugs
    _spec.loader.exec_module(_bugs)
    _place, _plant = _bugs.BUGS[bug]
    sys.meta_path.insert(0, _Finder(_place, _plant))
