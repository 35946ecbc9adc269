"""Dotted paths of a config's fields, and the nested mappings that they stand for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hgs_core.base.errors import InputError

__all__ = ["by_stage"]


def by_stage(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values that stand under dotted paths as nested mappings by stage, the plain form of a config.

    Raises:
        InputError: a field is given twice, as a part and by its path.
    """
    nested: dict[str, Any] = {}
    for name, value in values.items():
        *parts, last = name.split(".")
        target = nested
        for part in parts:
            target = target.setdefault(part, {})
            if not isinstance(target, dict):
                raise _twice(name, (*parts, last))
        if not _merge(target, last, value):
            raise _twice(name, (*parts, last))
    return nested


def _merge(target: dict[str, Any], name: str, value: Any, depth: int = 3) -> bool:  # no config is nested deeper
    """Put a value into a mapping, or the items of a mapping into the one there; False if something is there already."""
    if depth and isinstance(value, Mapping) and isinstance(target.setdefault(name, {}), dict):
        return all(_merge(target[name], item, below, depth - 1) for item, below in value.items())
    if name in target:
        return False
    target[name] = value
    return True


def _twice(name: str, path: tuple[str, ...]) -> InputError:
    return InputError.of_field(f"config.{name[:80]}", f"config.{'.'.join(path)[:80]} is given twice", "give it once")
