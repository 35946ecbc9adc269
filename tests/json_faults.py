"""Faults of JSON documents, as the files of tests/vectors list them: a place and the value there."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ["put"]


def put(document: Any, case: Mapping[str, Any]) -> None:
    """Put a case's value at its place in a document; remove the place for the value None."""
    *path, last = case["at"]
    for key in path:
        document = document[key]
    if case["value"] is None:
        del document[last]
    else:
        document[last] = case["value"]
