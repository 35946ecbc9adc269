"""Reading of JSON with errors that name the field by its path."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hgs_core.base.errors import InputError

__all__ = ["Field", "field_of"]

LARGEST_WHOLE = 1 << 53
HASH = re.compile(r"[0-9a-f]{64}")


@dataclass(frozen=True)
class Field:
    """A value somewhere inside a JSON document. Every reader raises `InputError` if the value is not of its type."""

    path: str
    value: Any

    def error(self, problem: str, cure: str = "") -> InputError:
        """Return the error about this field."""
        return InputError(self.path, problem, cure)

    def __getitem__(self, name: str) -> Field:
        mapping = self.mapping()
        if name not in mapping:
            raise InputError(f"{self.path}.{name}", "is missing")
        return Field(f"{self.path}.{name}", mapping[name])

    def mapping(self) -> Mapping[str, Any]:
        """Return an object."""
        if not isinstance(self.value, dict):
            raise self._expected("an object")
        return self.value

    def items(self, count: int | None = None) -> list[Field]:
        """Return the entries of a list, of `count` entries if given."""
        if not isinstance(self.value, list) or (count is not None and len(self.value) != count):
            raise self._expected("a list" if count is None else f"a list of {count}")
        return [Field(f"{self.path}[{i}]", entry) for i, entry in enumerate(self.value)]

    def text(self) -> str:
        """Return a string."""
        if not isinstance(self.value, str):
            raise self._expected("a string")
        return self.value

    def flag(self) -> bool:
        """Return true or false."""
        if not isinstance(self.value, bool):
            raise self._expected("true or false")
        return self.value

    def hash(self) -> str:
        """Return a SHA-256 in lower-case hex."""
        if not HASH.fullmatch(self.text()):
            raise self._expected("64 lower-case hex digits")
        return self.text()

    def number(self, low: float = -math.inf, above: float = -math.inf) -> float:
        """Return a finite number of at least `low` and greater than `above`."""
        value = self.value
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= sys.float_info.max:
            raise self._expected("a finite number")
        if value < low or value <= above:
            raise self._expected(f"at least {low}" if value < low else f"above {above}")
        return float(value)

    def numbers(self, count: int) -> tuple[float, ...]:
        """Return a list of `count` finite numbers."""
        return tuple(entry.number() for entry in self.items(count))

    def whole(self, low: int, high: int = LARGEST_WHOLE) -> int:
        """Return a whole number in [low, high]."""
        value = self.value
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            raise self._expected(f"a whole number from {low} to {high}")
        return value

    def _expected(self, expected: str) -> InputError:
        shown = repr(self.value)
        return self.error(f"is {shown if len(shown) <= 40 else shown[:37] + '...'}, expected {expected}")


def field_of(document: Any, where: object) -> Field:
    """Return the root of a document; `where` begins every path."""
    return Field(str(where), document)
