"""Fields of configs: checked, replaced by name, and listed by their dotted paths."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeVar

from hgs_core.base.errors import InputError
from hgs_core.base.wording import did_you_mean, shown

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

__all__ = ["Range", "check_fields", "flat_fields", "with_fields"]

Range = tuple[float, float]
"""The least and the greatest value that a number may have, both included."""

Config = TypeVar("Config", bound="DataclassInstance")

_SHOWN = 40  # characters of a bad value that an error repeats


def check_fields(
    values: Any, where: str, ranges: Mapping[str, Range], choices: Mapping[str, tuple[Any, ...]] = MappingProxyType({})
) -> None:
    """Check the fields of a frozen dataclass; whole numbers become int, others float, as the fields declare.

    Every number has its range in `ranges` or its values in `choices`, every string its values in `choices`. A part, a
    field made by a dataclass, has checked its own.

    Raises:
        InputError: a value of the wrong type, NaN, or out of range; names `where` and the field.
    """
    for field in dataclasses.fields(values):
        value, place = getattr(values, field.name), f"{where}.{field.name}"
        if dataclasses.is_dataclass(field.default_factory) and not isinstance(value, field.default_factory):
            raise InputError.of_field(place, f"{shown(value)} is not an object", "give {field: value}")
        known = choices[field.name] if field.type == "str" else choices.get(field.name)
        if field.type in ("int", "float"):
            low, high = ranges[field.name] if known is None else (min(known), max(known))
            value = _number(value, str(field.type), place, low, high)
            object.__setattr__(values, field.name, value)  # frozen for everybody else
        elif field.type == "bool" and not isinstance(value, bool):
            raise InputError.of_field(place, f"{shown(value)} is not true or false")
        if known is not None and value not in known:
            raise InputError.of_field(place, f"unknown choice {shown(value)}", f"use {_any_of(known)}")


def with_fields(config: Config, values: Mapping[str, Any], where: str) -> Config:
    """Return the config with fields replaced; those of a part are given as {field: value}, and lists become tuples.

    Raises:
        InputError: there is no such field, or a value is refused; names `where` and the field.
    """
    known = sorted(field.name for field in dataclasses.fields(config))
    changed: dict[str, Any] = {}
    for name, value in values.items():
        if name not in known:
            inside = [path for path in flat_fields(dataclasses.asdict(config)) if path.endswith(f".{name}")]
            meant = f"did you mean {inside[0]}?" if len(inside) == 1 else did_you_mean(name, known)
            cure = meant or f"known are {', '.join(known)}"
            raise InputError.of_field(f"{where}.{name[:_SHOWN]}", "unknown field", cure)
        part = getattr(config, name)
        if dataclasses.is_dataclass(part) and not isinstance(part, type) and isinstance(value, Mapping):
            value = with_fields(part, value, f"{where}.{name}")
        changed[name] = tuple(value) if isinstance(value, list) else value
    return dataclasses.replace(config, **changed)


def flat_fields(value: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return the plain form of a config with parts as one mapping, by dotted paths."""
    flat: dict[str, Any] = {}
    for name, item in value.items():
        flat |= flat_fields(item, f"{prefix}{name}.") if isinstance(item, dict) else {f"{prefix}{name}": item}
    return flat


def _number(value: Any, kind: str, where: str, low: float, high: float) -> float:
    cure = f"give a {'whole ' if kind == 'int' else ''}number from {low} to {high}"
    if not isinstance(value, int | float) or isinstance(value, bool):
        raise InputError.of_field(where, f"{shown(value)} is not a number", cure)
    if not low <= value <= high:  # NaN lies nowhere
        raise InputError.of_field(where, f"{shown(value)} is out of range", cure)
    if kind == "float":
        return float(value)
    if int(value) != value:
        raise InputError.of_field(where, f"{shown(value)} is not a whole number", cure)
    return int(value)


def _any_of(choices: tuple[Any, ...]) -> str:
    """Return "a, b or c"."""
    return f"{', '.join(str(choice) for choice in choices[:-1])} or {choices[-1]}"
