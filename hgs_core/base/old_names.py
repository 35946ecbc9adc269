"""Names that files, requests and command lines of earlier versions use, and what they are called now."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError

__all__ = ["OLD_NAMES", "with_new_names"]

OLD_NAMES: Mapping[str, str] = {"cycle": "iteration", "cycles": "iterations"}


def with_new_names(values: Mapping[str, Any], where: str | Path = "") -> dict[str, Any]:
    """Return the values with every old name replaced by the new one, in the same order.

    Raises:
        InputError: a value stands under both names; `where` and a dot precede the name in the message.
    """
    for old, new in OLD_NAMES.items():
        if old in values and new in values:
            place = f"{where}.{old}" if where else old
            raise InputError(place, f"is the old name of {new}, and both are given", f"give {new} alone")
    return {OLD_NAMES.get(name, name): value for name, value in values.items()}
