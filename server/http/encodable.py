"""Sanitising of JSON values, so that any stored row or manifest can be sent."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

__all__ = ["encodable"]


def encodable(value: Any) -> Any:
    """Return a JSON value with null for NaN and infinities, and with U+FFFD for lone surrogates."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, str):
        return value if value.isascii() else value.encode("utf-16", "surrogatepass").decode("utf-16", "replace")
    if isinstance(value, Mapping):
        return {encodable(name): encodable(one) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [encodable(one) for one in value]
    return value
