"""The threads of a function's calls: the pool's, or the main one."""

from __future__ import annotations

import threading
from types import ModuleType
from typing import Any

import pytest

__all__ = ["threads_of"]


def threads_of(monkeypatch: pytest.MonkeyPatch, module: ModuleType, name: str) -> set[str]:
    """Return a set to which every call of the module's function adds the name of its thread."""
    threads: set[str] = set()
    function = getattr(module, name)

    def noted(*arguments: Any, **options: Any) -> Any:
        threads.add(threading.current_thread().name)
        return function(*arguments, **options)

    monkeypatch.setattr(module, name, noted)
    return threads
