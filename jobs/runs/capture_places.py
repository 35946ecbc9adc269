"""Paths in run.json that differ from machine to machine: the capture and its sound."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

__all__ = ["SPEC", "Translation"]

SPEC = "run.json"
"""The file of a run folder that names the places."""


class Translation:
    """The paths in run.json that differ from machine to machine."""

    def __init__(self, portable: Callable[[str], str], local: Callable[[str], str]) -> None:
        """Translate the path of a capture, or of a file in it, from this machine's to everybody's, and back."""
        self._portable, self._local = portable, local

    def portable(self, spec: bytes) -> bytes:
        """Return run.json as it is saved."""
        return _with_places(spec, self._portable)

    def local(self, spec: bytes) -> bytes:
        """Return run.json as this machine needs it."""
        return _with_places(spec, self._local)


def _with_places(spec: bytes, translate: Callable[[str], str]) -> bytes:
    value: dict[str, Any] = json.loads(spec)
    for name in ("capture", "audio"):  # a file with sound may lie in the capture
        if isinstance(value.get(name), str):
            value[name] = translate(value[name])
    return json.dumps(value, indent=1).encode()
