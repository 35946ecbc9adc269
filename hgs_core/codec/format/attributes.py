"""The attributes a chunk can hold: their numbers, shapes and quantisers (docs/format.md, "Attributes")."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from hgs_core.codec.format.streams import Transform

__all__ = ["ATTRIBUTES", "BY_ID", "FIFTH", "LARGEST_FORM", "MOTION_ORDERS", "TURNS", "Attribute", "Kind"]

I = TypeVar("I", bound=np.integer)  # noqa: E741


class Kind(IntEnum):
    """The kinds of splats in a chunk."""

    STATIC = 0
    DYNAMIC = 1


@dataclass(frozen=True)
class Attribute:
    """One attribute: its id on the wire never changes its meaning."""

    id: int
    name: str
    components: int
    morton: bool = False  # the three codes interleaved, stored as differences of the ascending Morton codes
    transforms: tuple[Transform, ...] = (Transform.NONE, Transform.DELTA)  # those a decoder accepts
    dynamic_only: bool = False
    rows_of: int = 0  # order of motion, or bit of "form", that a splat must have to have a row; 0: every splat has one
    version: int = 2  # first format version with the attribute

    def planes(self, bits: int) -> int:
        """Return how many bytes a row has before compression."""
        return (3 * bits + 7) // 8 if self.morton else self.components * ((bits + 7) // 8)

    def among(self, forms: NDArray[I]) -> NDArray[np.bool_]:
        """Return which splats of these forms [N] have a row."""
        if not self.rows_of:
            return np.ones(len(forms), np.bool_)
        if self.rows_of in (TURNS, FIFTH):
            return np.asarray((forms & forms.dtype.type(self.rows_of)) != 0)
        return np.asarray((forms & forms.dtype.type(3)) >= self.rows_of)


TURNS = 4
"""The bit of "form" that says that a splat's rotation changes; the two bits below it hold the order of its motion."""

FIFTH = 8
"""The bit of "form" that says that a motion of order 3 goes on to the fifth order."""

LARGEST_FORM = {2: TURNS + 3, 3: FIFTH + TURNS + 3}
"""By the version of the format."""

_CHAINED = (Transform.NONE, Transform.DELTA, Transform.CHAIN)

ATTRIBUTES: dict[str, Attribute] = {
    attribute.name: attribute
    for attribute in (
        Attribute(1, "position", 3, True, (Transform.NONE,)),
        Attribute(2, "log_scale", 3, transforms=_CHAINED),
        Attribute(3, "rotation", 3),
        Attribute(4, "opacity", 1),
        Attribute(5, "rgb", 3, transforms=_CHAINED),
        Attribute(16, "time_center", 1, dynamic_only=True),
        Attribute(17, "time_log_precision", 1, dynamic_only=True),
        Attribute(18, "form", 1, dynamic_only=True),
        Attribute(19, "velocity", 3, dynamic_only=True, rows_of=1),
        Attribute(20, "acceleration", 3, dynamic_only=True, rows_of=2),
        Attribute(21, "jerk", 3, dynamic_only=True, rows_of=3),
        Attribute(22, "turning", 4, dynamic_only=True, rows_of=TURNS),
        Attribute(23, "snap", 3, dynamic_only=True, rows_of=FIFTH, version=3),
        Attribute(24, "crackle", 3, dynamic_only=True, rows_of=FIFTH, version=3),
    )
}
"""By name, in the order in which a chunk stores them."""

BY_ID: dict[int, Attribute] = {attribute.id: attribute for attribute in ATTRIBUTES.values()}

MOTION_ORDERS: tuple[str, ...] = ("velocity", "acceleration", "jerk", "snap", "crackle")
"""The attributes of the motion polynomial's coefficients of order 1 to 5."""
